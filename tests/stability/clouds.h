#pragma once

#include <string>
#include <vector>

#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"

/// Clouds and comparisons that several stages use.
namespace pointreel::stability {

/// A ball of radius 0.5 about `center` with evenly spaced points, normals and colours.
PointCloud ball_cloud(std::size_t count, const glm::dvec3& center = glm::dvec3(0.0));

/// The same points in another order.
PointCloud shuffled(const PointCloud& cloud);

/// The settings that differ in how they code, at this depth: the octree without and with entropy
/// coding, and Draco.
struct Setting {
  std::string name;
  EncodeOptions options;
};
std::vector<Setting> settings(int depth);

/// The largest error of a round trip on each axis in cells: half a cell plus the rounding of single
/// precision relative to the edge of the cube. Draco computes in single precision throughout, so
/// with 20 and 21 bits it occasionally chooses a neighbouring cell.
double allowed_cells(const Setting& setting, int depth);
inline constexpr const char* kAllowed =
    "half a cell on each axis plus two float roundings; Draco: plus 1e-6 of the edge, at most a "
    "cell";

/// The largest distance of any point, on any axis, from the leaf that it fell into, in cells.
/// `truth[i]` is the true position of point i of the cloud. Infinite if the decoded frame does not
/// match the cloud.
double round_trip_cells(const PointCloud& cloud, const std::vector<glm::dvec3>& truth,
                        const DecodedFrame& decoded);

/// The world coordinates of all points.
std::vector<glm::dvec3> positions_of(const PointCloud& cloud);

}  // namespace pointreel::stability
