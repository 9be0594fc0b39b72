#include "client/prepare/strip_frame.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "codec/core/build.h"
#include "codec/core/normal_lines.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

/// The share of distinct points that may fall together with others. The last few would make the
/// tree much deeper.
constexpr double kMayMeet = 0.02;

/// A cube around a box that is mostly the same for the next frame, so that what does not move keeps
/// its patches: its edge is a power of two, and its origin a multiple of an eighth of that.
Cube steady_cube(const Box& box) {
  const double edge = bounding_cube(box).edge;
  Cube cube;
  cube.edge = std::exp2(std::ceil(std::log2(edge * (8.0 / 7.0))));
  const double step = cube.edge / 8.0;
  cube.origin = glm::floor(box.min / step) * step;
  return cube;
}

/// Replaces a cloud by one with a point for each leaf of a tree, and makes that tree.
void merge_points(SceneFrame& scene, const Executor& executor) {
  const PointCloud& points = scene.cloud;
  const auto sorted =
      sort_to_depth(points, steady_cube(bounds(points)), DepthRule::by_delta(kMayMeet), executor);
  if (!sorted) return;  // only for a rule that makes no sense
  const int depth = sorted->depth, unused = 3 * (sorted->sorted.levels - depth);
  scene.svo = build_svo(sorted->sorted, depth, executor);
  scene.attributes = mean_attributes(scene.svo, points, sorted->sorted, executor);
  if (scene.normals_estimated && points.has_normals())
    scene.attributes.normals = mean_normal_lines(scene.svo, points, sorted->sorted, executor);
  const glm::vec3 offset(points.origin - scene.svo.cube.origin);
  std::vector<glm::vec3> positions;
  std::vector<float> radii;
  positions.reserve(scene.svo.leaf_count());
  radii.reserve(scene.svo.leaf_count());
  const std::vector<KeyIndex>& order = sorted->sorted.points;
  for (std::size_t begin = 0, end; begin < order.size(); begin = end) {
    const std::uint64_t key = order[begin].key >> unused;
    glm::dvec3 sum(0.0);
    float radius = 0.0f;
    for (end = begin; end < order.size() && order[end].key >> unused == key; ++end) {
      sum += glm::dvec3(points.positions[order[end].index]);
      radius = std::max(radius, points.radii[order[end].index]);
    }
    positions.push_back(offset + glm::vec3(sum / static_cast<double>(end - begin)));
    radii.push_back(radius);
  }
  scene.cloud = {};  // so that the surfels are the leaves
  scene.cloud = surfels_of(scene);
  scene.cloud.positions = std::move(positions);
  scene.cloud.radii = std::move(radii);
}

}  // namespace

void make_strips(SceneFrame& scene, const Executor& executor,
                 std::shared_ptr<const StripRecord>* record) {
  if (scene.cloud.empty())
    scene.cloud = surfels_of(scene);
  else
    merge_points(scene, executor);
  PointCloud& surfels = scene.cloud;
  if (surfels.normals.empty()) surfels.normals.resize(surfels.size(), glm::vec3(0.0f));
  const StripSurfels from{.svo = scene.svo,
                          .positions = surfels.positions,
                          .normals = surfels.normals,
                          .radii = surfels.radii,
                          .lines = scene.normals_estimated};
  if (record == nullptr) {
    scene.strips = make_strips(from, scene.attributes, {}, executor);
  } else {
    RecordedStrips made = update_strips(from, scene.attributes, *record, {}, executor);
    scene.strips = std::move(made.strips);
    *record = std::move(made.record);
  }
  scene.svo = {};
  scene.attributes = {};
  scene.radii = {};
  scene.heights = {};
}

}  // namespace pointreel
