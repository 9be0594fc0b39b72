#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "codec/core/lattice.h"
#include "codec/package/max_error.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"

namespace pointreel::point_lattice_test {
namespace {

/// Points of a lattice, as a reader would store them: rounded to floats around an origin.
PointCloud points_on(const PointLattice& lattice, const glm::dvec3& origin, unsigned seed,
                     int count = 300) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> cell(-120, 120);
  PointCloud cloud;
  cloud.origin = origin;
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 at(cell(random), cell(random), cell(random));
    cloud.positions.emplace_back(lattice.point + lattice.step * at - origin);
  }
  // Without these, all points could lie on a coarser lattice.
  cloud.positions.emplace_back(lattice.point - origin);
  cloud.positions.emplace_back(lattice.point + lattice.step - origin);
  return cloud;
}

TEST(PointLattice, is_found_wherever_points_lie_on_one) {
  for (const double step : {1000.0, 5.0, 1.0, 0.2, 0.001, 0.0005}) {
    for (const double shift : {0.0, 0.5, 0.3}) {
      for (const double away : {0.0, 1e6}) {
        const glm::dvec3 origin = glm::dvec3(away) * step;
        const PointLattice lattice{origin + glm::dvec3(shift, 0.0, -shift) * step, step};
        const PointCloud cloud = points_on(lattice, origin, 3);
        const std::optional<PointLattice> found = lattice_of(cloud);
        ASSERT_TRUE(found) << step << " " << shift << " " << away;
        EXPECT_DOUBLE_EQ(found->step, step);
      }
    }
  }
}

TEST(PointLattice, of_many_points_may_have_any_step) {
  for (const double step : {0.0018, 1.0 / 3.0, 0.7310586, 17.25}) {
    for (const double shift : {0.0, 0.4}) {
      const PointLattice lattice{glm::dvec3(shift * step), step};
      PointCloud cloud = points_on(lattice, {}, 4, 3000);
      const std::optional<PointLattice> found = lattice_of(cloud);
      ASSERT_TRUE(found) << step << " " << shift;
      EXPECT_NEAR(found->step, step, 1e-6 * step);
      EXPECT_EQ(lattice_cube(bounds(cloud), *found).depth, 8);
      cloud.positions[1000].x += static_cast<float>(0.317 * step);
      const std::optional<PointLattice> other = lattice_of(cloud);
      EXPECT_TRUE(!other || other->step < 0.5 * step);
    }
  }
}

TEST(PointLattice, is_not_found_for_points_anywhere) {
  std::mt19937 random(5);
  for (const float extent : {1e-3f, 0.4f, 3.0f, 5e3f, 1e9f}) {
    std::uniform_real_distribution<float> anywhere(-extent, extent);
    PointCloud cloud;
    for (int i = 0; i < 100; ++i) {
      cloud.positions.emplace_back(anywhere(random), anywhere(random), anywhere(random));
    }
    EXPECT_FALSE(lattice_of(cloud)) << extent;
    EXPECT_FALSE(lattice_of(PointCloud{}));
  }
  PointCloud nearly = points_on({{}, 1.0}, {}, 9);
  nearly.positions[50].y += 0.125f;
  const std::optional<PointLattice> found = lattice_of(nearly);
  EXPECT_TRUE(!found || found->step < 1.0);
}

TEST(PointLattice, makes_both_codecs_restore_points_to_the_last_bit_of_their_floats) {
  for (const double step : {50.0, 1.0, 0.001}) {
    for (const glm::dvec3 origin : {glm::dvec3(0.0), glm::dvec3(4e5, -7e5, 0.0) * step}) {
      const PointCloud cloud = points_on({origin, step}, origin, 11);
      const std::optional<PointLattice> found = lattice_of(cloud);
      ASSERT_TRUE(found);
      const VoxelCube voxels = lattice_cube(bounds(cloud), *found);
      EXPECT_EQ(voxels.depth, 8);
      const double error = geometry_error(cloud, voxels.cube, voxels.depth);
      EXPECT_LE(error, step >= 1.0 ? 0.0 : 1e-4 * step);
      DracoOptions draco;
      draco.position_bits = voxels.depth;
      const OctreeOptions octree{Entropy::zstd, DepthRule::fixed(voxels.depth)};
      for (const EncodeOptions& options : {EncodeOptions{octree}, EncodeOptions{draco}}) {
        const auto frame = encode_frame(cloud, voxels.cube, options);
        ASSERT_TRUE(frame);
        const auto back = decode_frame(layer_views(frame->layers));
        ASSERT_TRUE(back);
        for (std::size_t i = 0; i < back->cloud.size(); ++i) {
          const glm::dvec3 cells = (back->cloud.world(i) - found->point) / found->step;
          EXPECT_LE(glm::length(cells - glm::round(cells)), 1e-4);
        }
      }
    }
  }
}

TEST(PointLattice, of_two_clouds_is_the_finer_one_if_it_contains_the_other) {
  const auto step_of = [](const PointLattice& a, const PointLattice& b) {
    const std::optional<PointLattice> common = common_lattice(a, b);
    EXPECT_EQ(common.has_value(), common_lattice(b, a).has_value());
    return common ? common->step : 0.0;
  };
  EXPECT_EQ(step_of({{}, 1.0}, {{}, 0.5}), 0.5);
  EXPECT_EQ(step_of({{0.5, 0, 0}, 1.0}, {{}, 0.5}), 0.5);
  EXPECT_EQ(step_of({{0.5, 0, 0}, 1.0}, {{}, 1.0}), 0.0);
  EXPECT_EQ(step_of({{}, 0.5}, {{}, 0.2}), 0.0);
  EXPECT_EQ(step_of({{3, 0, 0}, 1.0}, {{-4, 1, 0}, 1.0}), 1.0);
}

}  // namespace
}  // namespace pointreel::point_lattice_test
