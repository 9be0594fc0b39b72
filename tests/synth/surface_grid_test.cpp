#include "datasets_synthetic/surface_grid.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "datasets_synthetic/body.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/random.h"
#include "datasets_synthetic/samplers/uniform.h"

namespace pointreel::surface_grid_test {
namespace {

bool within(const glm::ivec3& cell, const glm::ivec3& size) {
  return glm::all(glm::greaterThanEqual(cell, glm::ivec3(0))) &&
         glm::all(glm::lessThan(cell, size));
}

TEST(SurfaceGrid, lists_every_cell_near_the_surface_with_its_relevant_blends) {
  const Body body = pose_body(walk(0.7));
  const SurfaceGrid grid = SurfaceGrid::build(body.surface).value();
  std::uint64_t number = 0;
  const auto points = sample_uniform(body.surface, 3000, 5);
  for (const SurfacePoint& point : *points) {
    Random random(3, number++);
    const double offset = (2.0 * random.uniform() - 1.0) * 0.999 * SurfaceGrid::kShell;
    const glm::dvec3 p = point.position + offset * point.normal;
    const glm::ivec3 at = grid.cell_at(p);
    ASSERT_TRUE(within(at, grid.size()));
    ASSERT_TRUE(grid.block_occupied(at));
    const std::uint32_t cell = grid.find(at);
    ASSERT_NE(cell, SurfaceGrid::kNone);
    const SurfaceDistance all = distance_to(body.surface, p);
    const SurfaceDistance few = distance_to(body.surface, grid.blends(grid.cells()[cell]), p);
    EXPECT_EQ(all.distance.value, few.distance.value);
    EXPECT_EQ(all.primitive, few.primitive);
  }
}

TEST(SurfaceGrid, finds_each_of_its_cells_by_position) {
  const SurfaceGrid grid = SurfaceGrid::build(pose_body(walk(0.0)).surface).value();
  std::set<std::uint32_t> found;
  std::size_t blends = 0;
  for (const SurfaceGrid::Cell& cell : grid.cells()) {
    const glm::dvec3 center = cell.min + 0.5 * SurfaceGrid::kCell;
    const std::uint32_t number = grid.find(grid.cell_at(center));
    ASSERT_LT(number, grid.cells().size());
    EXPECT_EQ(grid.cells()[number].min, cell.min);
    found.insert(number);
    blends += cell.blend_count;
    // It is the true distance, and so small that the surface passes through the cell or just beside
    // it.
    EXPECT_NEAR(cell.distance, distance_to(grid.surface(), center).distance.value, 1e-12);
    EXPECT_LE(std::abs(cell.distance),
              0.5 * std::sqrt(3.0) * SurfaceGrid::kCell + SurfaceGrid::kShell);
  }
  EXPECT_EQ(found.size(), grid.cells().size());
  EXPECT_LT(blends, 6 * grid.cells().size());  // on average, few of the 50 blends reach a cell
}

TEST(SurfaceGrid, reports_space_far_from_the_surface_as_empty) {
  const Surface ball{{RoundCone{{1, 2, 3}, {1, 2, 3}, 0.3, 0.3}}, {{0, 0, 0.0}}};
  const SurfaceGrid grid = SurfaceGrid::build(ball).value();
  const glm::ivec3 center = grid.cell_at({1, 2, 3});
  ASSERT_TRUE(within(center, grid.size()));
  EXPECT_FALSE(grid.block_occupied(center));
  EXPECT_EQ(grid.find(center), SurfaceGrid::kNone);
  EXPECT_NE(grid.find(grid.cell_at({1.3, 2, 3})), SurfaceGrid::kNone);
  EXPECT_FALSE(within(grid.cell_at({0, 2, 3}), grid.size()));
}

TEST(SurfaceGrid, refuses_surfaces_that_are_empty_not_finite_or_too_large) {
  const auto ball = [](double x, double radius) {
    return Surface{{RoundCone{{x, 0, 0}, {0, 0, 0}, radius, radius}}, {{0, 0, 0.0}}};
  };
  EXPECT_FALSE(SurfaceGrid::build(Surface{}));
  EXPECT_FALSE(SurfaceGrid::build(ball(NAN, 1)));
  EXPECT_FALSE(SurfaceGrid::build(ball(100, 1)));
  EXPECT_TRUE(SurfaceGrid::build(ball(1, 1)));
}

}  // namespace
}  // namespace pointreel::surface_grid_test
