#pragma once

#include <cstddef>

#include "pointreel/chunks.h"
#include "pointreel/draco.h"

namespace pointreel {

/// The sizes of the geometry, the colours and the normals of a frame, including headers, in bytes.
/// With the scalar fields they add up to frame.size(). The other arguments are those that the frame
/// was encoded from.
///
/// Draco interleaves attributes, so the sizes of its parts are measured by encoding positions
/// alone, and then positions with colours; the rest is due to the normals. This takes up to two
/// more encodes. Headers count as geometry, and a part that does not make the frame larger counts
/// as 0.
Result<Chunks<std::size_t>> measure_part_sizes(const EncodedFrame& frame, const PointCloud& cloud,
                                               const Cube& cube, const EncodeOptions& options);

}  // namespace pointreel
