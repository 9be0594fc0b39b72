#include "codec/surface/clean.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/threads/tbb_executor.h"

namespace pointreel::clean_test {
namespace {

/// Points of the unit sphere with Gaussian noise along each axis, with normals and with colours
/// that tell each point.
PointCloud noisy_sphere(std::size_t count, double noise) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return glm::dvec3(normal(random), normal(random), normal(random)); };
  PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3 n = glm::normalize(vector());
    cloud.positions.emplace_back(n + noise * vector());
    cloud.normals.emplace_back(glm::normalize(n + 0.2 * vector()));
    cloud.colors.emplace_back(i & 0xff, i >> 8 & 0xff, i >> 16);
  }
  return cloud;
}

/// In shares of the sphere's radius.
double distance_from_sphere(const PointCloud& cloud, double radius = 1.0) {
  double sum = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double distance = glm::length(cloud.world(i)) / radius - 1.0;
    sum += distance * distance;
  }
  return std::sqrt(sum / static_cast<double>(cloud.size()));
}

double degrees_from_sphere(const PointCloud& cloud) {
  double sum = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 exact = glm::normalize(cloud.world(i));
    sum += std::acos(std::clamp(glm::dot(exact, glm::dvec3(cloud.normals[i])), -1.0, 1.0));
  }
  return 57.3 * sum / static_cast<double>(cloud.size());
}

bool equal(const PointCloud& a, const PointCloud& b) {
  return a.origin == b.origin && a.positions == b.positions && a.normals == b.normals &&
         a.colors == b.colors && a.radii == b.radii;
}

TEST(Clean, moves_noisy_points_onto_the_surface) {
  for (const double noise : {0.01, 0.03}) {
    PointCloud cloud = noisy_sphere(20'000, noise);
    const double distance = distance_from_sphere(cloud), degrees = degrees_from_sphere(cloud);
    const CleanReport report = clean(cloud);
    EXPECT_TRUE(report.cleaned);
    EXPECT_NEAR(report.noise, noise, 0.3 * noise);
    EXPECT_NEAR(report.spacing, std::sqrt(4.0 * 3.14159 / 20'000), 0.3 * report.spacing);
    EXPECT_LT(distance_from_sphere(cloud), 0.3 * distance);
    EXPECT_LT(degrees_from_sphere(cloud), 0.3 * degrees);
  }
}

TEST(Clean, finds_normals_across_the_gaps_between_scanned_curves) {
  // Meridians and parallels, with normals that were estimated along them: they turn around the
  // curve freely.
  PointCloud cloud;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const auto add = [&](double latitude, double longitude, const glm::dvec3& along) {
    const glm::dvec3 n(std::cos(latitude) * std::cos(longitude), std::sin(latitude),
                       std::cos(latitude) * std::sin(longitude));
    const glm::dvec3 aside = glm::cross(n, along);
    cloud.positions.emplace_back(n * (1.0 + 0.003 * normal(random)));
    cloud.normals.emplace_back(glm::normalize(n + 0.7 * normal(random) * aside));
  };
  for (int curve = -7; curve <= 7; ++curve) {
    for (int i = 0; i < 900; ++i) {
      const double a = 6.2832 * i / 900, latitude = 0.1 * curve;
      add(latitude, a, {-std::sin(a), 0.0, std::cos(a)});
    }
  }
  const double degrees = degrees_from_sphere(cloud);
  EXPECT_TRUE(clean(cloud).cleaned);
  EXPECT_LT(degrees_from_sphere(cloud), 0.2 * degrees);
}

TEST(Clean, gives_clouds_without_normals_those_of_the_surface) {
  PointCloud cloud = noisy_sphere(20'000, 0.01);
  cloud.normals.clear();
  EXPECT_TRUE(clean(cloud).cleaned);
  ASSERT_TRUE(cloud.has_normals());
  EXPECT_LT(degrees_from_sphere(cloud), 3.0);
}

TEST(Clean, leaves_smooth_clouds_as_they_are) {
  const PointCloud exact = noisy_sphere(20'000, 0.0);
  PointCloud cloud = exact;
  const CleanReport report = clean(cloud);
  EXPECT_FALSE(report.cleaned);
  EXPECT_EQ(report.why, NotCleaned::smooth);
  EXPECT_LT(report.noise, 0.1 * report.spacing);
  EXPECT_TRUE(equal(cloud, exact));
  cloud.normals.clear();
  clean(cloud);
  EXPECT_FALSE(cloud.has_normals());
}

TEST(Clean, leaves_clouds_without_normals_alone_if_told_to) {
  const PointCloud noisy = noisy_sphere(5'000, 0.02);
  PointCloud cloud = noisy;
  EXPECT_TRUE(clean(cloud, {.without_normals = false}).cleaned);
  PointCloud bare = noisy;
  bare.normals.clear();
  cloud = bare;
  EXPECT_EQ(clean(cloud, {.without_normals = false}).why, NotCleaned::no_normals);
  EXPECT_TRUE(equal(cloud, bare));
  EXPECT_TRUE(clean(cloud).cleaned);
}

TEST(Clean, keeps_the_two_sides_of_a_thin_plate_apart_that_normals_tell_apart) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  std::normal_distribution<double> normal;
  for (const double thickness : {0.01, 0.02, 0.04}) {
    PointCloud plate;
    for (int i = 0; i < 10'000; ++i) {
      const double side = i % 2 ? 1.0 : -1.0;
      plate.positions.emplace_back(place(random), side * thickness / 2.0 + 0.004 * normal(random),
                                   place(random));
      plate.normals.push_back(glm::normalize(
          glm::vec3(0.2 * normal(random), side + 0.2 * normal(random), 0.2 * normal(random))));
    }
    ASSERT_TRUE(clean(plate).cleaned);
    double sum = 0.0;
    for (const glm::vec3& p : plate.positions) {
      const double distance = std::abs(p.y) - thickness / 2.0;
      sum += distance * distance;
    }
    EXPECT_LT(std::sqrt(sum / static_cast<double>(plate.size())), 0.5 * 0.004) << thickness;
  }
}

TEST(Clean, leaves_smooth_clouds_as_they_are_whose_points_are_repeated) {
  const PointCloud once = noisy_sphere(5'000, 0.0);
  std::mt19937 random(2);
  std::normal_distribution<float> normal;
  for (const int copies : {2, 3, 6, 8}) {
    for (const float jitter : {0.0f, 1e-6f, 1e-4f, 5e-4f}) {
      PointCloud repeated;
      for (int copy = 0; copy < copies; ++copy) {
        for (const glm::vec3& p : once.positions)
          repeated.positions.push_back(
              p + jitter * glm::vec3(normal(random), normal(random), normal(random)));
      }
      PointCloud cloud = repeated;
      clean(cloud);
      EXPECT_TRUE(equal(cloud, repeated)) << copies << " copies, jitter " << jitter;
    }
  }
}

TEST(Clean, leaves_voxelised_surfaces_as_they_are) {
  std::set<std::array<int, 3>> cells;
  for (const glm::vec3& p : noisy_sphere(200'000, 0.0).positions) {
    const glm::ivec3 cell(glm::round(p * 60.0f));
    cells.insert({cell.x, cell.y, cell.z});
  }
  PointCloud voxels;
  for (const auto& [x, y, z] : cells) voxels.positions.emplace_back(x, y, z);
  PointCloud cloud = voxels;
  const CleanReport report = clean(cloud);
  EXPECT_FALSE(report.cleaned);
  EXPECT_EQ(report.why, NotCleaned::voxelised);
  EXPECT_EQ(report.spacing, 0.0) << "what fills its voxels need not be measured";
  EXPECT_TRUE(equal(cloud, voxels));
}

TEST(Clean, removes_points_that_no_surface_supports_and_keeps_attributes_together) {
  PointCloud cloud = noisy_sphere(20'000, 0.01);
  // Radii are not changed, so that they tell which point is which.
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.radii.push_back(static_cast<float>(i));
  const PointCloud source = cloud;
  std::mt19937 random(2);
  std::normal_distribution<float> normal;
  for (int i = 0; i < 50; ++i) {
    const glm::vec3 p(normal(random), normal(random), normal(random));
    cloud.positions.push_back(1.5f * p + glm::normalize(p));
    cloud.normals.push_back(glm::normalize(p));
    cloud.colors.emplace_back(0xffff, 0xffff, 0xffff);
    cloud.radii.push_back(1e6f);
  }
  const CleanReport report = clean(cloud);
  EXPECT_GE(report.removed, 45u);
  EXPECT_LT(report.removed, 100u);
  ASSERT_EQ(cloud.size(), source.size() + 50 - report.removed);
  ASSERT_EQ(cloud.colors.size(), cloud.size());
  ASSERT_EQ(cloud.normals.size(), cloud.size());
  ASSERT_EQ(cloud.radii.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.radii[i] == 1e6f) continue;
    const auto from = static_cast<std::size_t>(cloud.radii[i]);
    EXPECT_LT(glm::distance(cloud.positions[i], source.positions[from]), 0.1f);
  }
}

TEST(Clean, takes_noise_out_of_colours_but_not_edges) {
  PointCloud cloud = noisy_sphere(50'000, 0.02);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto level = [](const glm::vec3& p) { return p.y > 0.0f ? 50'000.0 : 15'000.0; };
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud.colors[i] =
        glm::u16vec3(glm::dvec3(level(cloud.positions[i]) + 3'000.0 * normal(random)));
  ASSERT_TRUE(clean(cloud).cleaned);
  double square = 0.0;
  std::size_t inside = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double error = cloud.colors[i].x - level(cloud.positions[i]);
    if (std::abs(cloud.positions[i].y) < 0.05) continue;  // at the edge, means blend
    square += error * error;
    ++inside;
  }
  ASSERT_GT(inside, 45'000u);
  EXPECT_LT(std::sqrt(square / static_cast<double>(inside)), 1'500.0) << "half of it";
}

TEST(Clean, keeps_colours_in_the_bits_that_they_had) {
  PointCloud cloud = noisy_sphere(20'000, 0.03);
  for (glm::u16vec3& color : cloud.colors) color = (color % glm::u16vec3(256)) * glm::u16vec3(257);
  const std::vector<glm::u16vec3> source = cloud.colors;
  ASSERT_TRUE(clean(cloud).cleaned);
  EXPECT_NE(cloud.colors, source);
  EXPECT_TRUE(colors_fit_8_bits(cloud));
}

TEST(Clean, takes_the_radius_that_it_is_given) {
  PointCloud little = noisy_sphere(20'000, 0.03), much = little;
  const CleanReport report = clean(little, {.radius = 0.05});
  EXPECT_FLOAT_EQ(static_cast<float>(report.radius), 0.05f);
  clean(much, {.radius = 0.2});
  EXPECT_LT(distance_from_sphere(much), 0.5 * distance_from_sphere(little));
  PointCloud smooth = noisy_sphere(20'000, 0.0);
  EXPECT_TRUE(clean(smooth, {.radius = 0.05}).cleaned);
}

TEST(Clean, depends_neither_on_the_order_of_the_points_nor_on_the_executor) {
  const PointCloud source = noisy_sphere(10'000, 0.02);
  PointCloud cloud = source, parallel = source, shuffled = source;
  std::vector<std::size_t> order(source.size());
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  for (std::size_t i = 0; i < order.size(); ++i) {
    shuffled.positions[i] = source.positions[order[i]];
    shuffled.normals[i] = source.normals[order[i]];
    shuffled.colors[i] = source.colors[order[i]];
  }
  clean(cloud);
  clean(parallel, {}, tbb_executor());
  clean(shuffled);
  EXPECT_TRUE(equal(cloud, parallel));
  const auto points = [](const PointCloud& of) {
    std::vector<std::array<float, 6>> all;
    for (std::size_t i = 0; i < of.size(); ++i) {
      const glm::vec3 &p = of.positions[i], &n = of.normals[i];
      all.push_back({p.x, p.y, p.z, n.x, n.y, n.z});
    }
    std::ranges::sort(all);
    return all;
  };
  EXPECT_EQ(points(cloud), points(shuffled));
}

TEST(Clean, far_from_zero_gives_the_same_to_a_float) {
  PointCloud cloud = noisy_sphere(10'000, 0.02);
  PointCloud far = cloud;
  far.origin = glm::dvec3(1e6, -3e6, 5e6);
  clean(cloud);
  clean(far);
  ASSERT_EQ(cloud.size(), far.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_LT(glm::distance(cloud.positions[i], far.positions[i]), 1e-3f);
  }
}

TEST(Clean, keeps_a_sparse_surface_beside_a_dense_one) {
  PointCloud cloud = noisy_sphere(20'000, 0.005);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> along(-1.0f, 1.0f);
  std::normal_distribution<float> across(0.0f, 0.005f);
  for (int i = 0; i < 700; ++i) {
    cloud.positions.emplace_back(along(random), -1.3f + across(random), along(random));
    cloud.normals.emplace_back(0.0f, 1.0f, 0.0f);
    cloud.colors.emplace_back(0, 0, 0);
  }
  const CleanReport report = clean(cloud);
  EXPECT_TRUE(report.cleaned);
  EXPECT_LT(report.removed, 50u) << "some, where the two are near each other";
}

/// Adds the points of `more`, made smaller and moved.
void add(PointCloud& cloud, const PointCloud& more, float scale, const glm::vec3& center) {
  for (std::size_t i = 0; i < more.size(); ++i) {
    cloud.positions.push_back(center + scale * more.positions[i]);
    cloud.normals.push_back(more.normals[i]);
    cloud.colors.push_back(more.colors[i]);
  }
}

TEST(Clean, leaves_small_clumps_alone_that_lie_far_apart) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(2.0f, 12.0f);
  PointCloud clumps;
  for (int i = 0; i < 500; ++i) {
    add(clumps, noisy_sphere(24, 0.05), 0.04f, {place(random), place(random), place(random)});
  }
  PointCloud cloud = noisy_sphere(20'000, 0.005);
  add(cloud, clumps, 1.0f, glm::vec3(0.0f));
  const CleanReport report = clean(cloud);
  EXPECT_TRUE(report.cleaned);
  EXPECT_LT(report.removed, 50u);
  std::size_t kept = 0;
  for (const glm::vec3& p : cloud.positions) {
    kept += std::ranges::find(clumps.positions, p) != clumps.positions.end() ? 1 : 0;
  }
  EXPECT_GT(kept, clumps.size() * 95 / 100) << "where they were";

  cloud = clumps;
  EXPECT_FALSE(clean(cloud).cleaned);
  EXPECT_TRUE(equal(cloud, clumps));
}

TEST(Clean, moves_no_point_far) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(-100.0f, 100.0f);
  PointCloud cloud = noisy_sphere(30'000, 0.005);
  for (int i = 0; i < 300; ++i) {
    cloud.positions.emplace_back(place(random), place(random), place(random));
    cloud.normals.push_back(glm::normalize(glm::vec3(place(random), place(random), 1.0f)));
    cloud.colors.emplace_back(0, 0, 0);
  }
  const std::vector<glm::vec3> source(cloud.positions.end() - 300, cloud.positions.end());
  const CleanReport report = clean(cloud);
  EXPECT_TRUE(report.cleaned);
  for (const glm::vec3& p : cloud.positions) {
    if (glm::length(p) < 1.1f) continue;
    const auto nearest =
        std::ranges::min(source, {}, [&](const glm::vec3& from) { return glm::distance(p, from); });
    EXPECT_LE(glm::distance(p, nearest), report.radius * 1.001);
  }
}

TEST(Clean, reports_cells_that_dense_parts_need) {
  for (const std::size_t dense : {2000u, 10'000u}) {
    PointCloud cloud = noisy_sphere(10'000, 0.01);
    add(cloud, noisy_sphere(dense, 0.006), 0.05f, {3.0f, 0.0f, 0.0f});
    const CleanReport report = clean(cloud);
    EXPECT_TRUE(report.cleaned);
    const double spacing = 0.05 * std::sqrt(4.0 * 3.14159 / static_cast<double>(dense));
    EXPECT_LT(report.cell, 1.3 * spacing) << dense;
    EXPECT_GT(report.cell, 0.5 * spacing) << dense;
  }
}

TEST(Clean, leaves_a_room_as_it_is_that_few_rings_of_a_lidar_see) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.002);
  PointCloud room;
  for (int ring = 0; ring < 16; ++ring) {
    const double up = glm::radians(-15.0 + 2.0 * ring);
    for (int step = 0; step < 1800; ++step) {
      const double around = glm::radians(0.2 * step);
      const glm::dvec3 way(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around),
                           std::sin(up));
      // To the walls, the floor or the ceiling, which are 4, 3 and 1.5 away.
      const double distance =
          1.0 / std::max({std::abs(way.x) / 4.0, std::abs(way.y) / 3.0, std::abs(way.z) / 1.5}) +
          noise(random);
      room.positions.emplace_back(distance * way);
    }
  }
  PointCloud cloud = room;
  EXPECT_FALSE(clean(cloud).cleaned);
  EXPECT_TRUE(equal(cloud, room));
}

TEST(Clean, gives_points_without_a_normal_one) {
  const PointCloud source = noisy_sphere(20'000, 0.02);
  for (const std::size_t one_in : {1u, 10u}) {
    PointCloud cloud = source;
    for (std::size_t i = 0; i < cloud.size(); i += one_in) cloud.normals[i] = glm::vec3(0.0f);
    const CleanReport report = clean(cloud);
    EXPECT_TRUE(report.cleaned);
    EXPECT_LT(report.removed, 20u);
    EXPECT_LT(degrees_from_sphere(cloud), 5.0);
  }
}

TEST(Clean, leaves_clouds_as_they_are_that_have_no_surface) {
  PointCloud line;
  for (int i = 0; i < 20'000; ++i) {
    line.positions.emplace_back(1e-4f * float(i), 0.0f, 0.0f);
    line.normals.emplace_back(0.0f, i % 3 == 0 ? 1.0f : -1.0f, 0.0f);
  }
  PointCloud sphere = noisy_sphere(20'000, 0.02);
  for (const auto& [source, options] :
       {std::pair{line, CleanOptions{}}, std::pair{sphere, CleanOptions{1e-6}}}) {
    PointCloud cloud = source;
    EXPECT_FALSE(clean(cloud, options).cleaned);
    EXPECT_TRUE(equal(cloud, source));
  }
}

TEST(Clean, does_the_same_at_every_scale_or_nothing) {
  const PointCloud source = noisy_sphere(5'000, 0.02);
  PointCloud expected = source;
  const CleanReport report = clean(expected);
  for (const float scale : {1e-30f, 1e-20f, 1e-10f, 1e-5f, 1e5f, 1e10f, 1e20f, 1e30f}) {
    PointCloud cloud = source;
    for (glm::vec3& p : cloud.positions) p *= scale;
    const PointCloud scaled = cloud;
    if (clean(cloud).cleaned) {
      EXPECT_EQ(cloud.size(), expected.size()) << scale;
      EXPECT_LT(distance_from_sphere(cloud, scale), 1.01 * distance_from_sphere(expected)) << scale;
    } else {
      EXPECT_TRUE(equal(cloud, scaled)) << scale;
      EXPECT_TRUE(scale < 1e-12f || scale > 1e14f) << scale;
    }
  }
  EXPECT_TRUE(report.cleaned);
}

TEST(Clean, survives_clouds_that_are_no_surfaces) {
  for (const int dimensions : {0, 1, 2, 3}) {
    PointCloud cloud;
    std::mt19937 random(4);
    std::uniform_real_distribution<float> uniform;
    for (int i = 0; i < 5000; ++i) {
      const glm::vec3 p(uniform(random), uniform(random), uniform(random));
      cloud.positions.emplace_back(dimensions > 0 ? p.x : 0.5f, dimensions > 1 ? p.y : 0.5f,
                                   dimensions > 2 ? p.z : 0.5f);
      cloud.normals.push_back(i % 3 == 0 ? glm::vec3(0.0f) : glm::normalize(p - 0.5f));
    }
    for (const bool normals : {true, false}) {
      if (!normals) cloud.normals.clear();
      for (const CleanOptions& options : {CleanOptions{}, CleanOptions{0.1}, CleanOptions{1e6}}) {
        PointCloud result = cloud;
        clean(result, options);
        for (const glm::vec3& p : result.positions) {
          ASSERT_TRUE(std::isfinite(p.x + p.y + p.z)) << dimensions;
        }
        for (const glm::vec3& n : result.normals) {
          ASSERT_TRUE(n == glm::vec3(0.0f) || std::abs(glm::length(n) - 1.0f) < 1e-3f);
        }
      }
    }
  }
  PointCloud empty;
  EXPECT_FALSE(clean(empty).cleaned);
}

}  // namespace
}  // namespace pointreel::clean_test
