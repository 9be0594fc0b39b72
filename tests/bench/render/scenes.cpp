#include "tests/bench/render/scenes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "client/prepare/prepare.h"
#include "codec/files/ply.h"
#include "common/base/spread.h"
#include "common/base/try.h"
#include "datasets_synthetic/random.h"
#include "datasets_synthetic/samplers/ldc.h"
#include "datasets_synthetic/samplers/uniform.h"
#include "datasets_synthetic/sequences.h"

namespace pointreel::bench {
namespace {

constexpr std::uint64_t kSeed = 1;

/// Candidates per point.
constexpr std::size_t kCandidates = 6;

/// The least distance of even points, in units of sqrt(area / points). With kCandidates, it gives
/// about the number of points that is asked for.
constexpr double kApart = 0.75;

/// Points that keep a distance from each other.
class DistantPoints {
 public:
  DistantPoints(double distance, std::size_t expected)
      : distance_(distance), heads_(std::bit_ceil(2 * expected), kNone) {}

  /// Adds the point, or returns false if it is too near to another.
  bool add(const glm::dvec3& p) {
    const glm::ivec3 cell(glm::floor(p / distance_));
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
          for (std::uint32_t i = heads_[slot(cell + glm::ivec3(x, y, z))]; i != kNone;
               i = next_[i]) {
            const glm::dvec3 d = points_[i] - p;
            if (glm::dot(d, d) < distance_ * distance_) return false;
          }
        }
      }
    }
    std::uint32_t& head = heads_[slot(cell)];
    next_.push_back(head);
    head = static_cast<std::uint32_t>(points_.size());
    points_.push_back(p);
    return true;
  }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  std::size_t slot(const glm::ivec3& cell) const {
    const std::uint64_t hash = static_cast<std::uint64_t>(cell.x) * 0x9e3779b97f4a7c15u ^
                               static_cast<std::uint64_t>(cell.y) * 0xc2b2ae3d27d4eb4fu ^
                               static_cast<std::uint64_t>(cell.z) * 0x165667b19e3779f9u;
    return (hash ^ hash >> 29) & (heads_.size() - 1);
  }

  double distance_;
  std::vector<std::uint32_t> heads_, next_;  // lists of points whose cells share a slot
  std::vector<glm::dvec3> points_;
};

}  // namespace

std::vector<SceneChoice> scene_choices(int poses, std::size_t even_points) {
  std::vector<SceneChoice> choices;
  for (const char* name : {"baseball", "basketball", "kick", "soccer-juggle", "soccer-shoot"}) {
    const Motion* motion = find_motion(name);
    const auto count = static_cast<std::size_t>(std::min(poses, motion->poses));
    for (std::size_t i = 0; i < count; ++i) {
      const auto pose =
          static_cast<int>(spread_index(i, count, static_cast<std::size_t>(motion->poses)));
      choices.push_back(
          {count > 1 ? fmt::format("{}, pose {}", name, pose) : name, motion, pose, 0});
    }
  }
  const Motion* kick = find_motion("kick");
  choices.push_back({"kick, dense", kick, kick->poses / 2, even_points});
  choices.push_back({"kick, dense, no colours", kick, kick->poses / 2, even_points, false});
  return choices;
}

Result<double> surface_area(const SurfaceGrid& grid) {
  const Lattice lattice{.spacing = 0.01};
  const auto hits = TRY(cast_lattice(grid, lattice));
  double area = 0.0;
  for (const LatticeHit& hit : hits) {
    area += lattice.spacing * lattice.spacing * std::abs(hit.point.normal[hit.axis]);
  }
  return area;
}

Result<PointCloud> even_cloud(const Body& body, double area, std::size_t points) {
  const auto candidates = TRY(sample_uniform(body.surface, kCandidates * points, kSeed));
  DistantPoints kept(kApart * std::sqrt(area / static_cast<double>(points)), points);
  PointCloud cloud;
  for (const SurfacePoint& point : candidates) {
    if (!kept.add(point.position)) continue;
    cloud.positions.emplace_back(point.position);
    cloud.normals.emplace_back(point.normal);
    cloud.colors.push_back(glm::u16vec3(color_at(body, point.primitive, point.position)) *
                           std::uint16_t{257});
  }
  return cloud;
}

Result<std::shared_ptr<const SceneFrame>> prepare_cloud(const PointCloud& cloud, DrawMode mode,
                                                        double delta) {
  FetchedFrame fetched;
  fetched.file = ply_bytes(cloud);
  auto frame = prepare_frame(fetched, {}, {mode, delta});
  if (!frame) return tl::unexpected(frame.error());
  return std::make_shared<const SceneFrame>(std::move(*frame));
}

Result<RenderScene> make_render_scene(const SceneChoice& choice) {
  SequenceOptions options;
  auto truth = make_truth_scene(pose_body(choice.motion->pose(choice.pose / options.fps)));
  if (!truth) return fail_at(choice.name, truth.error());
  const auto area = surface_area(truth->grid);
  if (!area) return fail_at(choice.name, area.error());
  auto cloud = choice.even_points > 0 ? even_cloud(truth->body, *area, choice.even_points)
                                      : sequence_frame(*choice.motion, options, choice.pose);
  if (!cloud) return fail_at(choice.name, cloud.error());
  const double spacing = std::sqrt(*area / static_cast<double>(cloud->size()));
  cloud->radii.clear();
  if (!choice.colors) cloud->colors.clear();
  if (choice.even_points > 0) {
    cloud->radii.assign(cloud->size(), static_cast<float>(kDenseRadius * spacing));
  }
  const PrepareOptions usual;
  auto surfels = prepare_cloud(*cloud, DrawMode::surfel, usual.delta);
  if (!surfels) return fail_at(choice.name, surfels.error());
  auto voxels = prepare_cloud(*cloud, DrawMode::voxel, usual.delta);
  if (!voxels) return fail_at(choice.name, voxels.error());
  return RenderScene{choice,  std::move(*truth),   *area,
                     spacing, std::move(*surfels), std::move(*voxels)};
}

std::shared_ptr<const SceneFrame> shuffled(const SceneFrame& frame, std::uint64_t seed) {
  const PointCloud& from = frame.cloud;
  std::vector<std::uint32_t> order(from.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint32_t>(i);
  Random random(seed, 0);
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
  }
  auto result = std::make_shared<SceneFrame>(frame);
  const auto reorder = [&order](const auto& source, auto& target) {
    for (std::size_t i = 0; i < source.size(); ++i) target[i] = source[order[i]];
  };
  reorder(from.positions, result->cloud.positions);
  reorder(from.normals, result->cloud.normals);
  reorder(from.colors, result->cloud.colors);
  reorder(from.radii, result->cloud.radii);
  return result;
}

std::shared_ptr<const SceneFrame> labelled(const SceneFrame& frame, const TruthScene& truth,
                                           const Camera& camera, double tolerance) {
  std::vector<glm::dvec3> points(frame.cloud.size());
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = frame.cloud.world(i);
  const std::vector<bool> hidden = hidden_points(truth, camera.eye(), points, tolerance);
  auto result = std::make_shared<SceneFrame>(frame);
  result->cloud.colors.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    result->cloud.colors[i] = glm::u16vec3(hidden[i] ? 0 : 0xffff);
  }
  return result;
}

}  // namespace pointreel::bench
