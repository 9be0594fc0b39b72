#include "pointreel/octree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "codec/core/build.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/samplers/uniform.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "tests/stability/check.h"
#include "tests/stability/clouds.h"

namespace pointreel::stability {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

PointCloud cloud_of(std::vector<glm::vec3> positions) {
  PointCloud cloud;
  cloud.positions = std::move(positions);
  return cloud;
}

/// The cloud, encoded and decoded again; nothing if either fails.
std::optional<DecodedFrame> through(const PointCloud& cloud, const Cube& cube,
                                    const EncodeOptions& options) {
  const auto frame = encode_frame(cloud, cube, options);
  if (!frame) return std::nullopt;
  auto decoded = decode_frame(layer_views(frame->layers));
  if (!decoded) return std::nullopt;
  return std::move(*decoded);
}

/// The largest error of a round trip in cells. Points are matched by their cell for the octree, and
/// by nearest neighbour for Draco.
double error_in_cells(const PointCloud& cloud, const Cube& cube, const Setting& setting,
                      int depth) {
  const auto decoded = through(cloud, cube, setting.options);
  if (!decoded) return kInfinity;
  if (decoded->svo) return round_trip_cells(cloud, positions_of(cloud), *decoded);
  if (decoded->cloud.size() != cloud.size()) return kInfinity;
  const double cell = std::ldexp(cube.edge, -depth);
  double worst = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    double nearest = kInfinity;
    for (std::size_t k = 0; k < decoded->cloud.size(); ++k) {
      const glm::dvec3 off = glm::abs(decoded->cloud.world(k) - cloud.world(i)) / cell;
      nearest = std::min(nearest, std::max({off.x, off.y, off.z}));
    }
    worst = std::max(worst, nearest);
  }
  return worst;
}

/// Random positions on a walking figure, which fill cells gradually as the depth decreases.
PointCloud figure_cloud(std::size_t count) {
  PointCloud cloud;
  const auto points = sample_uniform(pose_body(walk(0.4)).surface, count, 1);
  if (!points) return cloud;
  for (const SurfacePoint& point : *points) cloud.positions.push_back(glm::vec3(point.position));
  return cloud;
}

}  // namespace

Checks quantisation_checks() {
  Checks checks;
  const auto add = [&](const char* subject, const char* required, const PointCloud& cloud,
                       double edge, int depth) {
    const Cube cube = bounding_cube(bounds(cloud));
    double worst = 0.0;
    bool within = true;
    for (const Setting& setting : settings(depth)) {
      const double cells = error_in_cells(cloud, cube, setting, depth);
      within = within && cells <= allowed_cells(setting, depth);
      worst = std::max(worst, cells);
    }
    checks.push_back({"quantisation", subject, required,
                      fmt::format("edge {:g}, {:.4f} cells at depth {}", cube.edge, worst, depth),
                      cube.edge == edge && within});
  };
  add("maximum face", "edge 1; round trip within half a cell",
      cloud_of({{0, 0, 0}, {1, 1, 1}, {1, 0, 0.5f}, {0.3f, 1, 1}}), 1.0, 8);
  add("no extent", "plane: edge = largest extent; within half a cell",
      cloud_of({{0, 0, 5}, {3, 1, 5}, {1, 2, 5}}), 3.0, 9);
  add("no extent", "line: edge = largest extent; within half a cell",
      cloud_of({{7, 0, 5}, {7, 0.25f, 5}, {7, 2, 5}}), 2.0, 9);
  add("no extent", "point: edge 1; within half a cell", cloud_of({{7, -2, 5}, {7, -2, 5}}), 1.0, 4);
  const PointCloud single = cloud_of({{3, 4, 5}});
  const auto tree = sort_to_depth(single, bounding_cube(bounds(single)), DepthRule::by_delta(0.0));
  checks.push_back({"quantisation", "no extent", "a single point gives depth 0",
                    fmt::format("depth {}", tree ? tree->depth : -1), tree && tree->depth == 0});
  return checks;
}

Checks octree_checks() {
  Checks checks;
  const auto add = [&](const char* subject, const std::string& required, const std::string& outcome,
                       bool passed) {
    checks.push_back({"octree", subject, required, outcome, passed});
  };
  for (const Setting& setting : settings(6)) {
    const auto empty = through(PointCloud{}, Cube{}, setting.options);
    add("no points", "an empty frame", setting.name + (empty ? ": empty" : ": failed"),
        empty && empty->cloud.empty() && (!empty->svo || empty->svo->node_count() == 0));
  }
  const PointCloud same = cloud_of(std::vector<glm::vec3>(1000, glm::vec3(3, 4, 5)));
  for (const int depth : {0, 10, kMaxDepth}) {
    const Svo svo = build_svo(sort_points(same, bounding_cube(bounds(same))), depth);
    add("identical points", "one path to one cell",
        fmt::format("depth {}: {} nodes, {} leaf", depth, svo.node_count(), svo.leaf_count()),
        svo.leaf_count() == 1 && svo.node_count() == static_cast<std::uint32_t>(depth) + 1);
  }

  const PointCloud ball = ball_cloud(2000);
  const Cube cube = bounding_cube(bounds(ball));
  const auto depth_for = [&](double delta) {
    return sort_to_depth(ball, cube, DepthRule::by_delta(delta));
  };
  for (const double delta : {std::nan(""), -0.1, -kInfinity}) {
    const auto refused = depth_for(delta);
    add("delta out of range", "NaN and negative are refused",
        fmt::format("{}: {}", delta, refused ? "taken" : "refused"), !refused);
  }
  for (const double delta : {1.0, 2.0, kInfinity}) {
    const auto tree = depth_for(delta);
    add("delta out of range", "1 and more give depth 0",
        fmt::format("{}: depth {}", delta, tree ? tree->depth : -1), tree && tree->depth == 0);
  }
  // The two nearest points differ only at level 21.
  const PointCloud fine = cloud_of({{0, 0, 0}, {0x1p-21f, 0, 0}, {1, 1, 1}});
  const auto finest = sort_to_depth(fine, Cube{}, DepthRule::by_delta(0.0));
  add("delta out of range", "0 stops when all distinct points are separate, at level 21 at most",
      fmt::format("depth {}", finest ? finest->depth : -1), finest && finest->depth == kMaxDepth);
  const PointCloud finer = cloud_of({{0, 0, 0}, {0x1p-23f, 0, 0}, {1, 1, 1}});
  const auto last = sort_to_depth(finer, Cube{}, DepthRule::by_delta(0.0));
  add("delta out of range", "closer points, which level 21 cannot separate, stay together",
      fmt::format("depth {}, 2 of 3 cells", last ? last->depth : -1),
      last && last->depth <= kMaxDepth && last->sorted.occupied.back() == 2);

  for (const Setting& setting : settings(kMaxDepth)) {
    PointCloud far = ball_cloud(300, {1e6, -3e6, 12.5});
    far.positions.push_back({0.5f, 0.5f, 0.5f});
    far.normals.push_back({0, 1, 0});
    far.colors.push_back(glm::u16vec3(0));
    const Cube around = bounding_cube(bounds(far));
    const double cells = error_in_cells(far, around, setting, kMaxDepth);
    // The last bit of a double at 3e6 is a thousandth of such a cell; the last bit of a float is
    // more.
    add("level 21", std::string("63-bit keys; ") + kAllowed,
        fmt::format("{}: {:.4f} cells at an offset of 3e6", setting.name, cells),
        cells <= allowed_cells(setting, kMaxDepth));
  }
  return checks;
}

Checks delta_checks() {
  Checks checks;
  const PointCloud figure = figure_cloud(20000);
  const Cube cube = bounding_cube(bounds(figure));
  const double n = static_cast<double>(figure.size());
  int previous = kMaxDepth;
  for (const double delta : {0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9}) {
    const auto tree = sort_to_depth(figure, cube, DepthRule::by_delta(delta));
    if (!tree) {
      checks.push_back({"delta", fmt::format("{}", delta), "a depth", tree.error().message, false});
      continue;
    }
    const auto& occupied = tree->sorted.occupied;
    const auto loss = [&](int depth) {
      return 1.0 - occupied[static_cast<std::size_t>(depth)] / n;
    };
    const bool enough = loss(tree->depth) <= delta;
    const bool least = tree->depth == 0 || loss(tree->depth - 1) > delta;
    checks.push_back(
        {"delta", fmt::format("{}", delta),
         "the least depth that loses no more; never deeper for a larger delta",
         fmt::format("depth {}, {} leaves, {:.2f} % lost", tree->depth,
                     occupied[static_cast<std::size_t>(tree->depth)], 100.0 * loss(tree->depth)),
         enough && least && tree->depth <= previous});
    previous = tree->depth;
  }
  PointCloud twice = figure;
  twice.positions.insert(twice.positions.end(), figure.positions.begin(), figure.positions.end());
  const auto once = sort_to_depth(figure, cube, DepthRule::by_delta(0.05));
  const auto tree = sort_to_depth(twice, cube, DepthRule::by_delta(0.05));
  const bool ok = once && tree && tree->depth == once->depth;
  checks.push_back({"delta", "every point twice", "the depth of the distinct points",
                    fmt::format("depth {}, 50 % lost", tree ? tree->depth : -1), ok});
  return checks;
}

Checks depth_checks() {
  Checks checks;
  const PointCloud ball = ball_cloud(1000, {0.1, 0.2, 0.3});
  const Cube cube = bounding_cube(bounds(ball));
  for (int depth = 0; depth <= kMaxDepth; ++depth) {
    std::string outcome;
    bool passed = true;
    std::size_t leaves = 0;
    for (const Setting& setting : settings(depth)) {
      const bool draco = setting.options.id() == Codec::draco;
      if (draco && depth == 0) continue;  // Draco needs at least one bit
      if (!draco && setting.name != "octree") continue;
      const double cells = error_in_cells(ball, cube, setting, depth);
      passed = passed && cells <= allowed_cells(setting, depth);
      outcome += fmt::format(", {} {:.4f} cells", setting.name, cells);
    }
    leaves = build_svo(sort_points(ball, cube), depth).leaf_count();
    checks.push_back({"depth of the octree", fmt::format("{}", depth), kAllowed,
                      fmt::format("{} leaves{}", leaves, outcome), passed});
  }
  return checks;
}

}  // namespace pointreel::stability
