#include "codec/package/max_error.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "codec/files/cloud_file.h"
#include "datasets_synthetic/hard_cases.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"

namespace pointreel::max_error_test {
namespace {

EncodeOptions octree(int depth) {
  return {OctreeOptions{Entropy::zstd, DepthRule::fixed(depth)}, false, false};
}

EncodeOptions draco(int bits, DracoMethod method) {
  DracoOptions options;
  options.position_bits = bits;
  options.method = method;
  return {options, false, false};
}

PointCloud decoded(const PointCloud& cloud, const Cube& cube, const EncodeOptions& options) {
  const auto frame = encode_frame(cloud, cube, options);
  EXPECT_TRUE(frame) << (frame ? "" : frame.error().message);
  if (!frame) return {};
  const auto back = decode_frame(layer_views(frame->layers));
  EXPECT_TRUE(back) << (back ? "" : back.error().message);
  return back ? back->cloud : PointCloud{};
}

/// The largest distance from points of `a`, chosen all over it, to the nearest point of `b`. It is
/// exact up to the last bits of a double, whereas cloud_distance computes in floats.
double farthest(const PointCloud& a, const PointCloud& b) {
  const std::size_t step = a.size() / 60 + 1;
  long double most = 0.0L;
  for (std::size_t i = 0; i < a.size(); i += step) {
    long double nearest = HUGE_VALL, point[3];
    for (int axis = 0; axis < 3; ++axis)
      point[axis] =
          (static_cast<long double>(a.origin[axis]) - b.origin[axis]) + a.positions[i][axis];
    for (const glm::vec3& other : b.positions) {
      const long double x = point[0] - other.x, y = point[1] - other.y, z = point[2] - other.z;
      nearest = std::min(nearest, x * x + y * y + z * z);
    }
    most = std::max(most, nearest);
  }
  return static_cast<double>(std::sqrt(most));
}

/// The largest distance from a point to the nearest of the other cloud, in both directions, as a
/// share of the codec's bound at this depth.
double share_of_bound(const PointCloud& cloud, const EncodeOptions& options, int depth) {
  const Cube cube = bounding_cube(bounds(cloud));
  const PointCloud back = decoded(cloud, cube, options);
  if (back.empty()) return 2.0;
  return std::max(farthest(cloud, back), farthest(back, cloud)) / max_geometry_error(cube, depth);
}

void expect_within(const PointCloud& cloud, const std::string& what) {
  const bool large = cloud.size() > 5000;
  for (const int depth : large ? std::vector{12} : std::vector{0, 7, 12, 21}) {
    SCOPED_TRACE(what + ", depth " + std::to_string(depth));
    EXPECT_LE(share_of_bound(cloud, octree(depth), depth), 1.0);
    if (depth == 0) continue;
    for (const DracoMethod method : {DracoMethod::kd_tree, DracoMethod::sequential}) {
      EXPECT_LE(share_of_bound(cloud, draco(depth, method), depth), 1.0);
    }
  }
}

/// Points everywhere in a cube, at those of its corners that its bounding box includes, and near
/// the faces of cells.
PointCloud scattered(const glm::dvec3& origin, double extent, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> anywhere(0.0, extent);
  std::uniform_int_distribution<int> cell(0, 1 << 12);
  PointCloud cloud;
  cloud.origin = origin;
  for (int i = 0; i < 60; ++i) {
    cloud.positions.emplace_back(glm::dvec3(anywhere(random), anywhere(random), anywhere(random)));
    const glm::dvec3 face(cell(random), cell(random), cell(random));
    cloud.positions.emplace_back(face * (extent / 4096.0));
  }
  cloud.positions.emplace_back(0.0f);
  cloud.positions.emplace_back(glm::dvec3(extent));
  return cloud;
}

TEST(MaxGeometryError, holds_for_every_hard_case) {
  for (const HardCase& hard : hard_cases()) {
    if (!hard.expect.reads() || !hard.expect.packs) continue;
    const auto loaded =
        read_cloud({reinterpret_cast<const std::uint8_t*>(hard.bytes.data()), hard.bytes.size()});
    ASSERT_TRUE(loaded) << hard.file;
    if (loaded->cloud.empty()) continue;
    expect_within(loaded->cloud, hard.file);
  }
}

TEST(MaxGeometryError, holds_far_from_zero_and_for_huge_and_tiny_extents) {
  for (const double extent : {1e-12, 1e-3, 1.0, 1.7, 1e7, 3e20}) {
    for (const double away : {0.0, 1.0, 1e6, -3e12}) {
      const glm::dvec3 origin(away * extent, -away * extent, 0.1 * extent);
      expect_within(scattered(origin, extent, 7),
                    "extent " + std::to_string(extent) + " at " + std::to_string(away));
    }
  }
}

TEST(MaxGeometryError, is_no_larger_than_necessary) {
  // Points exactly at the corners of cells are half a diagonal away from the centre.
  PointCloud corners = scattered(glm::dvec3(0.0), 4096.0, 3);
  for (const int depth : {2, 7, 12}) {
    EXPECT_GT(share_of_bound(corners, octree(depth), depth), 0.99);
    EXPECT_GT(share_of_bound(corners, draco(depth, DracoMethod::kd_tree), depth), 0.99);
  }
  for (const int depth : {15, 18}) {
    const PointCloud cloud = scattered({5.0, 6.0, 7.0}, 1.0, 5);
    EXPECT_GT(share_of_bound(cloud, octree(depth), depth), 0.8);
  }
}

TEST(MaxGeometryError, holds_for_prefixes_of_the_layers) {
  const PointCloud cloud = scattered({1e5, -2e5, 3.0}, 2.5, 11);
  const Cube cube = bounding_cube(bounds(cloud));
  const auto frame = encode_frame(cloud, cube, octree(12));
  ASSERT_TRUE(frame);
  auto layers = layer_views(frame->layers);
  for (const int level : {12, 9, 7}) {
    const auto back = decode_frame(layers);
    ASSERT_TRUE(back);
    const double error = farthest(cloud, back->cloud);
    EXPECT_LE(error, max_geometry_error(cube, level));
    EXPECT_GT(error, max_geometry_error(cube, level + 1));
    layers.pop_back();
  }
}

TEST(GeometryError, is_between_the_true_error_and_the_bound) {
  for (const double extent : {1e-3, 1.7, 1e7}) {
    for (const double away : {0.0, 1e6}) {
      const PointCloud cloud = scattered(glm::dvec3(away, -away, 0.1) * extent, extent, 13);
      const Cube cube = bounding_cube(bounds(cloud));
      for (const int depth : {1, 7, 12, 19}) {
        const double error = geometry_error(cloud, cube, depth);
        EXPECT_LE(error, max_geometry_error(cube, depth) * (1.0 + 1e-12));
        for (const EncodeOptions& options : {octree(depth), draco(depth, DracoMethod::kd_tree)}) {
          const PointCloud back = decoded(cloud, cube, options);
          EXPECT_GE(error, farthest(cloud, back));
          EXPECT_GE(error, farthest(back, cloud));
        }
      }
    }
  }
}

}  // namespace
}  // namespace pointreel::max_error_test
