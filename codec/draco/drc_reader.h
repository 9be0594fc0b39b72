#pragma once

#include <string>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads any .drc file that Draco can read: point clouds (sequential or kd-tree) and the vertices
/// of meshes (sequential or edgebreaker), quantised or not, with positions of any data type.
/// Normals need three components. Colours may have one component (grey) to four (alpha is dropped)
/// of any type; integers are divided by the largest value of their type, and all values are clamped
/// to 0..1. Other attributes are named in `unread`, if that is given. A mesh repeats vertices at
/// texture seams, so vertices that are equal in everything that is read become one point; point
/// clouds keep their duplicates. The cloud's origin is 0 unless a coordinate exceeds twice the
/// longest extent; then it is the minimum corner. Positions may be NaN or infinite, and normals of
/// any length: `sanitize` the result.
///
/// Trust: the bytes may be hostile. Before Draco runs, the counts for which it allocates memory are
/// bounded (drc_header.h) and metadata are removed; what it returns is checked before it is read,
/// and nothing is thrown. Decoding itself is as memory-safe as the installed libdraco, which is
/// stopped before it takes more memory than DecodeLimits::max_memory. An attribute of texture
/// coordinates of a mesh counts as 512 MiB, because it may make Draco 1.5.5 take half as much and
/// ten seconds.
Result<PointCloud> read_drc(ByteView bytes, const DecodeLimits& limits = {},
                            std::vector<std::string>* unread = nullptr);

}  // namespace pointreel
