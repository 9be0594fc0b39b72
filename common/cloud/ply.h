#pragma once

#include <filesystem>

#include "pointreel/bytes.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads the vertices of a PLY file: ascii, binary little or big endian, every scalar type, lists
/// and other elements (faces) anywhere. Properties of element "vertex" that are read, the first
/// complete spelling of each attribute counting:
///   positions  x y z
///   normals    nx ny nz, or normal_x normal_y normal_z; as they stand, not normalised
///   colours    red green blue, r g b, or diffuse_red diffuse_green diffuse_blue:
///              uchar v as 257 v; ushort as it is; float and double from 0..1, clamped, NaN as 0;
///              char as the uchar of the same bits; other integers as 8-bit values, clamped
///   radii      radius
/// An attribute that is missing or incomplete is absent from the cloud. Everything else is skipped;
/// bytes after the last element are ignored.
///
/// The cloud's origin is 0 unless the largest coordinate by magnitude exceeds twice the longest
/// extent: then it is the minimum corner of the box, subtracted in double before the conversion to
/// float. Points with a coordinate that no float can hold, finite, are kept (`sanitize` drops them)
/// but have no say in this.
///
/// Trust: `bytes` may be anything. Memory is at most a constant times bytes.size(), whatever the
/// header declares, and time linear. The error is one line that names the line (header, ascii) or
/// the byte (binary), and the element and property; not the file.
Result<PointCloud> read_ply(ByteView bytes);

/// The cloud as a binary little-endian PLY file at world coordinates: positions as float where that
/// loses nothing (origin 0, or every world coordinate is a float), else double; normals as float;
/// colours as uchar where 8 bits hold them (`colors_fit_8_bits`), else ushort; radii as float
/// "radius". read_ply gives the same world coordinates, and attributes bit by bit.
Bytes ply_bytes(const PointCloud& cloud);

/// Writes `ply_bytes(cloud)` to a file, replacing it. The error begins with the path.
Result<void> write_ply(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace pointreel
