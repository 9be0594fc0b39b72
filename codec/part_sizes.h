#pragma once

#include <cstddef>

#include "pointreel/chunks.h"
#include "pointreel/draco.h"

namespace pointreel {

/// Bytes of the geometry, the colours and the normals of an octree frame, headers included. They
/// add up to frame.size().
Chunks<std::size_t> octree_part_sizes(const EncodedFrame& frame);

/// The same of a frame of either codec, which was encoded from these arguments. Draco interleaves
/// attributes, so its parts are measured by encoding positions alone, then with colours; what
/// remains is the normals'. This takes as long as two more encodes. The headers count as geometry,
/// and a part that makes the frame no larger counts as 0.
Result<Chunks<std::size_t>> measure_part_sizes(const EncodedFrame& frame, const PointCloud& cloud,
                                               const Cube& cube, const EncodeOptions& options);

}  // namespace pointreel
