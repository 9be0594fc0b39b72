#pragma once

#include "pointreel/bytes.h"
#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads any .drc that Draco can read: point clouds (sequential, kd-tree) and meshes (sequential,
/// edgebreaker; their vertices), quantised or not, positions of any data type. Normals need three
/// components. Colours may have one (grey) to four (alpha is dropped) of any type: integers are
/// fractions of their type's largest value, floats of 1, negative ones 0. Other attributes are
/// ignored. Where texture seams make a mesh repeat a vertex, points that are equal in all that is
/// kept become one; point clouds keep their duplicates. The cloud's origin is 0 unless a coordinate
/// exceeds twice the longest extent; then it is the minimum corner. Positions may be NaN or
/// infinite and normals of any length: `sanitize` the result.
///
/// Trust: the bytes may be hostile. Ours: the counts that Draco takes memory for first are bounded
/// before it runs (drc_header.h), metadata never reaches it, what it returns is checked before it
/// is read, and nothing is thrown. Draco's: decoding proper, which is as memory-safe as the
/// installed libdraco. Its memory is bounded for point clouds (kMaxComponents values a point); for
/// meshes it is bounded by the number of attributes that fit into the file times the points, and
/// each attribute of quantised texture coordinates may make Draco 1.5.5 take up to 256 MiB and ten
/// seconds more. So meshes are for input that a user chose, not for what a network brings.
Result<PointCloud> read_drc(ByteView bytes, const DecodeLimits& limits = {});

}  // namespace pointreel
