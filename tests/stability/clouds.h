#pragma once

#include <string>
#include <vector>

#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"

/// What several stages check with.
namespace pointreel::stability {

/// A ball of radius 0.5 about `center`, the points evenly apart, with normals and colours.
PointCloud ball_cloud(std::size_t count, const glm::dvec3& center = glm::dvec3(0.0));

/// The points in another order.
PointCloud shuffled(const PointCloud& cloud);

/// Every setting that codes differently, at this depth: octree without and with entropy coding, and
/// Draco.
struct Setting {
  std::string name;
  EncodeOptions options;
};
std::vector<Setting> settings(int depth);

/// What a round trip may be off on an axis, in cells: half of one, and what single precision loses
/// relative to the cube's edge. Draco computes in it throughout; with 20 and 21 bits that makes it
/// choose a neighbouring cell here and there.
double allowed_cells(const Setting& setting, int depth);
inline constexpr const char* kAllowed =
    "half a cell an axis, two float roundings; Draco 1e-6 of the edge, at most a cell";

/// How far each point is from the leaf that it fell into, on the axis where that is most, in cells;
/// of all points the largest. `truth[i]` is where point i of the cloud really is. Infinite where
/// the decoded frame is not what the cloud gives.
double round_trip_cells(const PointCloud& cloud, const std::vector<glm::dvec3>& truth,
                        const DecodedFrame& decoded);

/// World coordinates of all points.
std::vector<glm::dvec3> positions_of(const PointCloud& cloud);

}  // namespace pointreel::stability
