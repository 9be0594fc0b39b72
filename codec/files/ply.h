#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "codec/files/read_notes.h"
#include "pointreel/bytes.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads the vertices of a PLY file: ascii or binary of either byte order, with any scalar types,
/// and with lists and other elements (such as faces) anywhere. These properties of the element
/// "vertex" are read, under the names of attribute_names.h:
///   positions  x y z
///   normals    kept as they are, not normalised
///   colours    uchar v becomes 257 v, and char is read as the uchar of the same bits; in other
///              types, full_color.h says what stands for full brightness. Else packed colours, or
///              f_dc_0 f_dc_1 f_dc_2 of Gaussian splats, which are 0.5 + 0.2821 f
///   radii      radius
///   scalars    the first kMaxScalars of all other scalar properties whose names can be those of
///              scalar fields; in ascii, what is not a number is NaN. The shape of splats is none
/// The cloud does not have an attribute that is missing or incomplete. Everything else is skipped,
/// and bytes after the last element are ignored. Damaged elements after the vertices cost no more
/// than a warning.
///
/// The cloud's origin is 0 unless the largest coordinate by magnitude exceeds twice the longest
/// extent; then it is the minimum corner of the bounding box, and is subtracted in double before
/// the conversion to float. Doubles and numbers in ascii that lie far from zero but for a few
/// points are relative to the whole coordinates below their middle. Points with a coordinate that
/// is not a finite float do not affect the origin, and remain in the cloud (`sanitize` drops them).
///
/// The error names the line (header, ascii) or the byte (binary), the element and the property, but
/// not the file. Errors: `limit` if the header has too many elements or properties, otherwise
/// `invalid`.
///
/// Trust: the bytes may be hostile. Memory is at most a constant times bytes.size(), whatever the
/// header declares, and time is linear in it.
///
/// `notes`, unless null, receives the names of the vertices' scalar properties that are skipped,
/// and may say what stands for full brightness.
Result<PointCloud> read_ply(ByteView bytes, ReadNotes* notes = nullptr);

/// True if floats hold the world coordinates of all finite points exactly.
bool world_fits_float(const PointCloud& cloud);

/// The cloud as a binary little-endian PLY file in world coordinates: positions as float where that
/// loses nothing (the origin is 0, or every world coordinate is a float), otherwise as double;
/// normals as float; colours as uchar where 8 bits suffice (`colors_fit_8_bits`), otherwise as
/// ushort; radii as float "radius"; scalar fields as float, in the order in which the cloud has
/// them. read_ply restores the world coordinates and attributes exactly. Names of scalar fields
/// lose their blanks, which become "_", and begin with "scalar_" where another property has that
/// name or read_ply would take the field for another attribute.
Bytes ply_bytes(const PointCloud& cloud);

/// The same with faces: triangles of vertices of the cloud, as an element "face" after the
/// vertices, with lists of the type uchar uint named "vertex_indices".
Bytes ply_bytes(const PointCloud& vertices, std::span<const glm::uvec3> triangles);

/// Writes `ply_bytes(cloud)` to a file, replacing an existing one. The error (`io`) begins with the
/// path.
Result<void> write_ply(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace pointreel
