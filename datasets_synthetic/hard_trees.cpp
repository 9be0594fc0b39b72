#include "datasets_synthetic/hard_trees.h"

#include <limits>
#include <utility>

#include "datasets_synthetic/random.h"

namespace pointreel {
namespace {

/// Points at k / (n - 1) * extent on each axis for k = 0 .. n - 1; a single layer where an extent
/// is 0.
std::vector<glm::dvec3> grid(int n, const glm::dvec3& extent) {
  std::vector<glm::dvec3> points;
  const auto layers = [&](int axis) { return extent[axis] > 0.0 ? n : 1; };
  for (int z = 0; z < layers(2); ++z) {
    for (int y = 0; y < layers(1); ++y) {
      for (int x = 0; x < layers(0); ++x) {
        points.push_back(glm::dvec3(x, y, z) / static_cast<double>(n - 1) * extent);
      }
    }
  }
  return points;
}

void add(CaseList& list, const char* row, const char* file, const char* title,
         const PlyTable& table) {
  list.add(row, file, title, table, expect_table(table));
}

/// A case with the depth and the leaves of the tree that must result.
void add(CaseList& list, const char* row, const char* file, const char* title,
         const PlyTable& table, int depth, std::size_t leaves) {
  list.add(row, file, title, table, with_tree(expect_table(table), depth, leaves));
}

void add_cubes(std::vector<HardCase>& cases) {
  CaseList list(cases, "quantisation");
  add(list, "maximum face", "maximum_face.ply",
      "Points on the three maximum faces, edges and the far corner of their cube",
      positions({{0, 0, 0}, {1, 1, 1}, {1, 0, 0}, {1, 0.5, 0.5}}), 2, 4);
  // 16 points along each axis fill 16 cells: the last point lies on the maximum face and is
  // clamped.
  add(list, "maximum face", "grid_cube.ply", "16 x 16 x 16 points that fill their cube's cells",
      positions(grid(16, glm::dvec3(1.5))), 4, 4096);
  constexpr const char* kFlat = "no extent";
  add(list, kFlat, "flat_one_axis.ply", "A sheet: no extent along y",
      positions(grid(16, {1.5, 0, 1.5})), 4, 256);
  add(list, kFlat, "flat_two_axes.ply", "A line: no extent along y and z",
      positions(grid(16, {1.5, 0, 0})), 4, 16);
  add(list, kFlat, "flat_three_axes.ply", "Three points in the same place",
      positions({{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}), 0, 1);
  add(list, kFlat, "single_point.ply", "One point", positions({{1, 2, 3}}), 0, 1);
  add(list, kFlat, "single_point_far.ply", "One point at (1e9, -1e9, 1e9) in doubles",
      positions({{1e9 + 0.25, -1e9, 1e9}}, PlyType::float64), 0, 1);
  constexpr const char* kExtreme = "extreme extent";
  const auto add_unpackable = [&list](const char* file, const char* title, const PlyTable& table) {
    HardExpectation expect = with_tree(expect_table(table), 4, 16);
    expect.packs = false;  // the cube of a frame must have an edge between 1e-30 and 1e30
    list.add(kExtreme, file, title, table, expect);
  };
  add_unpackable(
      "extent_denormal.ply",
      "A line of 16 points within the smallest numbers that a float can hold",
      positions(
          grid(16, {15.0 * static_cast<double>(std::numeric_limits<float>::denorm_min()), 0, 0})));
  std::vector<glm::dvec3> huge = grid(16, {6e38, 0, 0});
  for (glm::dvec3& p : huge) p.x -= 3e38;
  add_unpackable("extent_huge.ply",
                 "A line of 16 points from -3e38 to 3e38: its extent is no float", positions(huge));
  std::vector<glm::dvec3> needle = grid(16, {1.5e6, 0, 0});
  for (std::size_t i = 0; i < needle.size(); ++i) needle[i].y = 1e-6 * static_cast<double>(i % 2);
  add(list, kExtreme, "extent_needle.ply", "A needle, 1.5e6 long and 1e-6 wide", positions(needle),
      4, 16);
}

void add_trees(std::vector<HardCase>& cases) {
  CaseList list(cases, "octree");
  PlyTable none = ball(0);
  add(list, "no points", "no_points.ply", "Normals and colours declared for no point at all", none,
      0, 0);
  std::vector<glm::dvec3> many(1000, glm::dvec3(0.1, 0.2, 0.3));
  add(list, "identical points", "identical_points.ply", "A thousand points in the same place",
      positions(many), 0, 1);
  many.push_back({5, 0.2, 0.3});
  add(list, "identical points", "identical_points_but_one.ply",
      "A thousand points in the same place and one elsewhere", positions(many), 1, 2);
  PlyTable twice = ball(1000);
  const PlyTable once = twice;
  twice.rows.insert(twice.rows.end(), once.rows.begin(), once.rows.end());
  add(list, "identical points", "every_point_twice.ply",
      "A ball each of whose points is there twice", twice);
  // 5e-7 is above 2^-21 and below 2^-20.
  add(list, "level 21", "level_21.ply", "Two points that only level 21 tells apart, and a far one",
      positions({{0, 0, 0}, {1, 1, 1}, {5e-7, 0, 0}}), 21, 3);
  add(list, "level 21", "level_21_far_corner.ply",
      "Two points at the far corner, where all keys are largest, 2^-20 apart",
      positions({{0, 0, 0}, {1, 1, 1}, {1.0 - 0x1p-20, 1, 1}}, PlyType::float64), 21, 3);
  add(list, "level 21", "level_22.ply", "Two points that level 22 would tell apart: they are one",
      positions({{0, 0, 0}, {1, 1, 1}, {2.4e-7, 0, 0}}), 1, 2);
  PlyTable shuffled = ball(2000);
  add(list, "input order", "order_spiral.ply", "A ball, from its top to its bottom", shuffled);
  Random random(1, 0);
  for (std::size_t i = shuffled.rows.size() - 1; i > 0; --i) {
    std::swap(shuffled.rows[i], shuffled.rows[random.below(static_cast<std::uint32_t>(i + 1))]);
  }
  add(list, "input order", "order_shuffled.ply",
      "The same ball, shuffled: it must be coded as the same bytes", shuffled);
}

void add_drawing(std::vector<HardCase>& cases) {
  CaseList list(cases, "drawing");
  const auto with_normal = [](PlyTable table, auto&& normal) {
    table.add_columns(PlyType::float32, {"nx", "ny", "nz"}, [&](std::size_t row) {
      const glm::dvec3 n = normal(row);
      return std::vector<double>{n.x, n.y, n.z};
    });
    return table;
  };
  constexpr double kUlp = std::numeric_limits<float>::epsilon();
  add(list, "surfel frame", "normals_at_the_poles.ply",
      "A sheet with the normals (0, +-1, 0) and beside them by one unit in the last place",
      with_normal(positions(grid(16, {1.5, 0, 1.5})), [](std::size_t row) {
        const double sign = row % 2 == 0 ? 1.0 : -1.0;
        const double aside = row % 3 == 0 ? 0.0 : row % 3 == 1 ? kUlp : -kUlp;
        return glm::dvec3(row % 4 < 2 ? aside : 0.0, sign, row % 4 < 2 ? 0.0 : aside);
      }));
  add(list, "normal cone", "normals_opposed.ply",
      "A sheet whose neighbours have opposed normals: no side of it may be culled",
      with_normal(positions(grid(32, {1.5, 1.5, 0})), [](std::size_t row) {
        return glm::dvec3(0, 0, (row + row / 32) % 2 == 0 ? 1 : -1);
      }));
  std::vector<glm::dvec3> plate = grid(32, {1.5, 1.5, 0});
  const std::size_t half = plate.size();
  for (std::size_t i = 0; i < half; ++i) plate.push_back(plate[i] + glm::dvec3(0, 0, 1e-4));
  add(list, "depth", "thin_plate.ply", "Two sheets 1e-4 apart that face away from each other",
      with_normal(positions(plate),
                  [half](std::size_t row) { return glm::dvec3(0, 0, row < half ? -1 : 1); }));
  std::vector<glm::dvec3> circle;
  for (const auto& [x, y] : {std::pair{3, 4}, {4, 3}, {5, 0}, {0, 5}}) {
    for (const int sx : {-1, 1}) {
      for (const int sy : {-1, 1}) circle.emplace_back(sx * x, sy * y, 0);
    }
  }
  add(list, "Delaunay", "cocircular.ply",
      "Points on a circle, exactly, four of them twice: every triangulation is right",
      positions(circle));
}

}  // namespace

void add_tree_cases(std::vector<HardCase>& cases) {
  add_cubes(cases);
  add_trees(cases);
  add_drawing(cases);
}

}  // namespace pointreel
