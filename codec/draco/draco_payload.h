#pragma once

#include <cstddef>

#include "pointreel/bytes.h"
#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

/// Point clouds as Draco codes them: what a Draco frame carries besides the common headers.
///
/// A payload is a complete .drc file (bitstream 2.3, kd-tree or sequential, no metadata), which any
/// Draco decoder reads, with float positions in cells from the cube's minimum corner, optionally
/// float normals, and colours of 8 bits where all of them fit, else 16.
///
/// - Positions are the centres of the cells that the cube has at octree level `position_bits`, a
///   cell being 1: at most half a cell off on each axis, the same cells in every frame that shares
///   the cube, and the same as the octree codec's at that depth. Points outside the cube clamp to
///   its boundary cells (ERRATA 12).
/// - Normals of a kd-tree are quantised to `normal_bits` on each axis with 0 among the values, so
///   that unknown normals stay unknown. Off by at most asin(sqrt(3) / (2^bits - 2)): 0.4 degrees at
///   8 bits.
/// - The sequential coder folds normals onto an octahedron of `normal_bits` on each of two axes,
///   which has no place for unknown ones: where a frame has some, a generic attribute of one byte a
///   point, 1 or 0, says which are known. Off by at most asin(4 / (2^bits - 2)): 0.9 degrees.
/// - Colours are exact.
/// - Duplicates are kept; the order of the points is not: they come in Morton order to the coder.
///   Radii are not coded.
/// - As with draco_encoder, a level of 0 means the sequential coder unless a method is asked for.
/// - Zero bytes follow the .drc where it would otherwise be so short for its points that the
///   decoder's bound (drc_header.h) refused it: many points in very few cells.
/// - No points: no bytes.
namespace pointreel {

/// Options must lie in the ranges that DracoOptions states; the cube's edge between 1e-30 and
/// 1e30; at most 2^26 points. The bytes depend on the set of the points and nothing else.
Result<Bytes> encode_draco_payload(const PointCloud& cloud, const Cube& cube,
                                   const DracoOptions& options, bool normals, bool colors);

/// Decodes what was encoded with these `position_bits`, 1 to 21, into a cloud whose origin is the
/// cube's.
///
/// Trust: the payload may be hostile. Only what the encoder writes is accepted: a point cloud of
/// the attributes above, in that order. Counts are bounded by `limits` and by kFreePoints +
/// kPointsPerFrameByte * payload.size() before Draco takes memory (about 100 bytes a point);
/// positions that decode to a place outside the cube, and NaN, are refused; nothing is thrown. The
/// decoding itself is Draco's and as memory-safe as the installed libdraco.
Result<PointCloud> decode_draco_payload(ByteView payload, const Cube& cube, int position_bits,
                                        const DecodeLimits& limits = {});

}  // namespace pointreel
