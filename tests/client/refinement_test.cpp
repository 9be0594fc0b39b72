#include "client/scene/refinement.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "tests/client/cloud_frame.h"

namespace pointreel::refinement_test {
namespace {

constexpr glm::ivec2 kSize{320, 240};

/// A sphere of radius 1 in coordinates of its own.
PointCloud sphere(std::size_t points) {
  std::mt19937 random(1);
  std::normal_distribution<float> gauss;
  PointCloud cloud;
  const auto radius = static_cast<float>(std::sqrt(4.0 * 3.14159 / static_cast<double>(points)));
  for (std::size_t i = 0; i < points; ++i) {
    const float z = gauss(random), y = gauss(random), x = gauss(random);
    const glm::vec3 n = glm::normalize(glm::vec3(x, y, z));
    cloud.positions.push_back(n);
    cloud.normals.push_back(n);
    cloud.radii.push_back(radius);
    cloud.colors.push_back(glm::u16vec3(32768.0f + 32000.0f * n));
  }
  return cloud;
}

Camera camera_at(double distance) {
  Camera camera;
  camera.target = {0.0, 0.0, 1.0};
  camera.distance = distance;
  return camera;
}

TEST(Refinement, divides_a_sphere_into_surfels_of_a_pixel_on_its_surface) {
  const PointCloud cloud = sphere(3'000);
  Refinement refinement;
  refinement.run(cloud_frame(cloud), camera_at(0.5), kSize);
  ASSERT_GT(refinement.surfels().size(), 10'000u);
  const double pixel = 2.0 * std::tan(0.5 * Camera{}.fov_y) / kSize.y;
  double of_surfels = 0.0, of_normals = 0.0, of_colors = 0.0;
  for (const RefinedSurfel& surfel : refinement.surfels()) {
    const float off = glm::length(surfel.position) - 1.0f;
    of_surfels += static_cast<double>(off) * off;
    const glm::vec3 n = glm::normalize(surfel.position);
    of_normals += std::acos(std::clamp(static_cast<double>(glm::dot(n, surfel.normal)), -1.0, 1.0));
    of_colors += glm::distance(glm::vec3(surfel.color), 32768.0f + 32000.0f * n) / 65535.0;
    EXPECT_LT(surfel.radius, 3.0 * pixel * glm::distance(surfel.position, glm::vec3(0, 0, 1.5)));
  }
  const auto count = static_cast<double>(refinement.surfels().size());
  const double radius = cloud.radii[0];
  EXPECT_LT(std::sqrt(of_surfels / count), 0.01 * radius) << "flat discs: 0.02";
  EXPECT_LT(of_normals / count, 0.01);
  EXPECT_LT(of_colors / count, 0.01);
}

TEST(Refinement, keeps_colours_sharp_along_dense_curves_with_gaps_between_them) {
  // As a scanner samples a surface: 2.5 mm along curves that are 20 mm apart.
  PointCloud plane;
  for (int row = -10; row <= 10; ++row) {
    for (int i = -80; i < 80; ++i) {
      const float x = 0.0025f * (static_cast<float>(i) + 0.5f);
      plane.positions.emplace_back(x, 0.02f * static_cast<float>(row), 0.0f);
      plane.normals.emplace_back(0.0f, 0.0f, 1.0f);
      plane.colors.emplace_back(x < 0.0f ? glm::u16vec3(0) : glm::u16vec3(65535));
      plane.radii.push_back(0.012f);
    }
  }
  Camera camera;
  camera.distance = 0.3;
  Refinement refinement;
  refinement.run(cloud_frame(plane), camera, kSize);
  std::size_t near_edge = 0;
  for (const RefinedSurfel& surfel : refinement.surfels()) {
    if (std::abs(surfel.position.y) > 0.05f) continue;
    EXPECT_NEAR(surfel.position.z, 0.0f, 1e-4f);
    const float to_row = std::abs(std::remainder(surfel.position.y, 0.02f));
    if (std::abs(surfel.position.x) < 0.01f + 1.5f * to_row) continue;
    ++near_edge;
    EXPECT_NEAR(surfel.color.x, surfel.position.x < 0.0f ? 0 : 65535, 655)
        << surfel.position.x << " " << surfel.position.y;
  }
  EXPECT_GT(near_edge, 1'000u);
}

TEST(Refinement, keeps_the_shape_of_even_points_below_surfels_that_are_larger_than_they_need) {
  // Waves of 60 mm, sampled every 4 mm, with surfels that would close gaps of 20 mm.
  constexpr float kHeight = 0.003f, kWave = 2.0f * 3.14159265f / 0.06f;
  PointCloud waves;
  for (int y = -60; y <= 60; ++y) {
    for (int i = -60; i <= 60; ++i) {
      const float x = 0.004f * (static_cast<float>(i) + 0.5f * static_cast<float>(y & 1));
      const float slope = kHeight * kWave * std::cos(kWave * x);
      waves.positions.emplace_back(x, 0.0035f * static_cast<float>(y),
                                   kHeight * std::sin(kWave * x));
      waves.normals.push_back(glm::normalize(glm::vec3(-slope, 0.0f, 1.0f)));
      waves.radii.push_back(0.014f);
    }
  }
  Camera camera;
  camera.distance = 0.3;
  Refinement refinement;
  refinement.run(cloud_frame(waves), camera, kSize);
  double square = 0.0, count = 0.0;
  for (const RefinedSurfel& surfel : refinement.surfels()) {
    if (glm::length(glm::vec2(surfel.position)) > 0.15f) continue;
    const float off = surfel.position.z - kHeight * std::sin(kWave * surfel.position.x);
    square += static_cast<double>(off) * off;
    ++count;
  }
  ASSERT_GT(count, 5'000.0);
  EXPECT_LT(std::sqrt(square / count), 0.05 * kHeight) << "fitted within three radii: 0.22";
}

TEST(Refinement, leaves_no_gaps_between_surfels) {
  const PointCloud cloud = sphere(3'000);
  Refinement refinement;
  const Camera camera = camera_at(0.5);
  refinement.run(cloud_frame(cloud), camera, kSize);
  // Directions that the camera sees in the middle of its picture.
  std::mt19937 random(2);
  std::uniform_real_distribution<float> near(-0.1f, 0.1f);
  for (int i = 0; i < 200; ++i) {
    const glm::vec3 place = glm::normalize(glm::vec3(near(random), near(random), 1.0f));
    const bool covered =
        std::ranges::any_of(refinement.surfels(), [&](const RefinedSurfel& surfel) {
          return glm::distance(surfel.position, place) < 1.4f * surfel.radius;
        });
    EXPECT_TRUE(covered) << place.x << ' ' << place.y;
  }
}

TEST(Refinement, leaves_surfels_alone_that_look_small_or_are_not_in_the_picture) {
  Refinement refinement;
  const auto frame = cloud_frame(sphere(3'000));
  refinement.run(frame, camera_at(50.0), kSize);
  EXPECT_TRUE(refinement.surfels().empty());
  EXPECT_TRUE(refinement.divided().empty());
  refinement.run(frame, camera_at(0.5), kSize);
  const auto divided = refinement.divided();
  ASSERT_EQ(divided.size(), 3'000u);
  EXPECT_LT(std::count(divided.begin(), divided.end(), true), 2'000);
  Camera away = camera_at(0.5);
  away.target.z = 100.0;
  refinement.run(frame, away, kSize);
  EXPECT_TRUE(refinement.surfels().empty());
}

TEST(Refinement, takes_trees_and_clouds_alike) {
  const PointCloud cloud = sphere(3'000);
  auto tree = std::make_shared<SceneFrame>();
  const SortedPoints sorted = sort_points(cloud, Cube{glm::dvec3(-1.5), 3.0}, 14);
  tree->svo = build_svo(sorted, 14);
  tree->attributes = mean_attributes(tree->svo, cloud, sorted);
  tree->radii.assign(tree->svo.node_count(), cloud.radii[0]);
  Refinement of_cloud, of_tree;
  of_cloud.run(cloud_frame(cloud), camera_at(0.5), kSize);
  of_tree.run(tree, camera_at(0.5), kSize);
  const auto expected = static_cast<double>(of_cloud.surfels().size());
  EXPECT_NEAR(static_cast<double>(of_tree.surfels().size()), expected, 0.02 * expected);
  for (const RefinedSurfel& surfel : of_tree.surfels())
    EXPECT_NEAR(glm::length(surfel.position - 1.5f), 1.0f, 0.01f) << "relative to the cube";
}

TEST(Refinement, makes_a_bounded_number_of_surfels) {
  PointCloud cloud = sphere(20'000);
  std::fill(cloud.radii.begin(), cloud.radii.end(), 0.5f);  // as another sampling might ask for
  Refinement refinement;
  refinement.run(cloud_frame(cloud), camera_at(1.5), {4096, 4096});
  EXPECT_LT(refinement.surfels().size(), 2'000'000u);
}

TEST(Refinement, survives_frames_that_are_no_surfaces) {
  std::vector<PointCloud> clouds(5);
  clouds[0].positions.assign(100, glm::vec3(0, 0, 1));
  for (int i = 0; i < 100; ++i) {
    clouds[1].positions.emplace_back(0.01f * static_cast<float>(i), 0, 1);
    clouds[2].positions.emplace_back(i % 7, i % 5, i % 3);
  }
  clouds[3].positions = {glm::vec3(0, 0, 1)};
  for (PointCloud& cloud : clouds) {
    for (std::size_t kind = 0; kind < 4; ++kind) {
      cloud.normals.assign(cloud.size(), kind == 0 ? glm::vec3(0) : glm::vec3(0, 0, 1));
      if (kind == 1 && !cloud.empty()) cloud.normals[0] = glm::vec3(0, 0, -1);
      cloud.radii.assign(cloud.size(), kind == 2 ? 0.0f : kind == 3 ? 1e30f : 0.05f);
      Refinement refinement;
      refinement.run(cloud_frame(cloud), camera_at(0.5), kSize);
      for (const RefinedSurfel& surfel : refinement.surfels()) {
        EXPECT_TRUE(std::isfinite(glm::length(surfel.position)));
        EXPECT_NEAR(glm::length(surfel.normal), 1.0f, 1e-3f);
      }
    }
  }
}

TEST(Refinement, leaves_frames_without_normals_as_they_are) {
  PointCloud cloud = sphere(1'000);
  cloud.normals.clear();
  Refinement refinement;
  refinement.run(cloud_frame(cloud), camera_at(0.5), kSize);
  EXPECT_TRUE(refinement.surfels().empty());
}

}  // namespace
}  // namespace pointreel::refinement_test
