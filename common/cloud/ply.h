#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads the vertices of a PLY file: ascii or binary of either byte order, with any scalar types,
/// and with lists and other elements (such as faces) anywhere. These properties of the element
/// "vertex" are read; if an attribute has several spellings, the first complete one counts:
///   positions  x y z
///   normals    nx ny nz, or normal_x normal_y normal_z; kept as they are, not normalised
///   colours    red green blue, r g b, or diffuse_red diffuse_green diffuse_blue:
///              uchar v becomes 257 v; ushort is kept, or read as uchar if none is above 255; float
///              and double are clamped to 0..1, or to 0..255 if the largest is above 2 and no more
///              than 255; NaN is 0; char is read as the uchar of the same bits; other integers are
///              8-bit values, clamped
///   radii      radius
///   scalars    the first kMaxScalars of all other scalar properties whose names can be those of
///              scalar fields; in ascii, what is not a number is NaN
/// The cloud does not have an attribute that is missing or incomplete. Everything else is skipped,
/// and bytes after the last element are ignored.
///
/// The cloud's origin is 0 unless the largest coordinate by magnitude exceeds twice the longest
/// extent; then it is the minimum corner of the bounding box, and is subtracted in double before
/// the conversion to float. Points with a coordinate that is not a finite float do not affect the
/// origin, and remain in the cloud (`sanitize` drops them).
///
/// The error names the line (header, ascii) or the byte (binary), the element and the property, but
/// not the file. Errors: `limit` if the header has too many elements or properties, otherwise
/// `invalid`.
///
/// Trust: the bytes may be hostile. Memory is at most a constant times bytes.size(), whatever the
/// header declares, and time is linear in it.
///
/// `unread`, unless null, receives the names of the vertices' scalar properties that are skipped,
/// in a form that fits into a one-line message.
Result<PointCloud> read_ply(ByteView bytes, std::vector<std::string>* unread = nullptr);

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
