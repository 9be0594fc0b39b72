#pragma once

#include <cstddef>

#include "pointreel/bytes.h"
#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

/// Point clouds coded by Draco: the payload of a Draco frame.
///
/// A payload is a complete .drc file (bitstream 2.3, kd-tree or sequential, no metadata), which any
/// Draco decoder reads. It has float positions in units of cells from the cube's minimum corner,
/// float normals if the frame has any, and colours of 8 bits if that is enough, otherwise 16.
///
/// - Positions are the centres of the cube's cells at octree level `position_bits`, where a cell
/// has
///   the edge 1. They are off by at most half a cell on each axis, and are the same cells in every
///   frame that shares the cube, and in the octree codec at that depth. Points outside the cube
///   move to the cells at its boundary (FORMULAS.md, "Cube of a frame").
/// - The kd-tree coder quantises normals to `normal_bits` on each axis. 0 is among the values, so
///   that unknown normals stay unknown. Normals are off by at most asin(sqrt(3) / (2^bits - 2)),
///   which is 0.4 degrees for 8 bits.
/// - The sequential coder folds normals onto an octahedron with `normal_bits` on each of its two
///   axes, which cannot represent unknown normals. If a frame has any, a generic attribute of one
///   byte for each point is 1 where the normal is known and 0 elsewhere. Normals are off by at most
///   asin(4 / (2^bits - 2)), which is 0.9 degrees for 8 bits.
/// - Colours are exact.
/// - Duplicates are kept, but the order of the points is not: they are coded in Morton order. Radii
///   are not coded.
/// - As with draco_encoder, level 0 means the sequential coder unless a method is chosen.
/// - Zero bytes follow the .drc file if it is too short for its number of points to pass the
///   decoder's bound (drc_header.h). This happens with many points in very few cells.
/// - The payload of a frame without points is empty.
namespace pointreel {

/// Encodes a cloud. The bytes depend on the set of points only. Errors: `argument` if an option is
/// outside the range that DracoOptions states, or the cube's edge is not between 1e-30 and 1e30;
/// `limit` for more than 2^26 points.
Result<Bytes> encode_draco_payload(const PointCloud& cloud, const Cube& cube,
                                   const DracoOptions& options, bool normals, bool colors);

/// Decodes a payload that was encoded with the same cube and `position_bits` (1 to 21). The origin
/// of the cloud is the cube's.
///
/// Trust: the payload may be hostile. Only what the encoder writes is accepted: a point cloud with
/// the attributes above, in that order. Counts are bounded by `limits` and by kFreePoints +
/// kPointsPerFrameByte * payload.size() before Draco allocates memory, which `limits` bound too.
/// Positions outside the cube and NaN are refused, and nothing is thrown. Decoding itself is as
/// memory-safe as the installed libdraco.
Result<PointCloud> decode_draco_payload(ByteView payload, const Cube& cube, int position_bits,
                                        const DecodeLimits& limits = {});

}  // namespace pointreel
