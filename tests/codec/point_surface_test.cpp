#include "codec/surface/point_surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "codec/surface/algebraic_sphere.h"
#include "codec/surface/place_sums.h"
#include "common/threads/tbb_executor.h"
#include "pointreel/cpu.h"

namespace pointreel::point_surface_test {
namespace {

constexpr float kRadius = 0.15f;

/// Points on the unit sphere, moved along the normals by up to `noise`.
PointCloud rough_sphere(std::size_t count, double noise, std::uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-noise, noise);
  PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3 n = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    cloud.positions.emplace_back(n * (1.0 + uniform(random)));
    cloud.normals.emplace_back(n);
  }
  return cloud;
}

/// One projection of a point, over all points of the cloud and in double precision.
SurfaceSample slow_sample(const PointCloud& cloud, std::size_t index, float radius, double beta,
                          int steps) {
  const glm::dvec3 start(cloud.positions[index]);
  glm::dvec3 place = start, normal(cloud.normals[index]);
  double weight = 0.0;
  for (int step = 0; step < steps; ++step) {
    SphereSums sums;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const glm::dvec3 p = glm::dvec3(cloud.positions[i]) - place;
      const glm::dvec3 n(cloud.normals[i]);
      const double share = 1.0 - glm::dot(p, p) / (double{radius} * radius);
      if (share > 0.0 && glm::dot(n, normal) > 0.3) sums.add(p, n, std::pow(share, 4.0));
    }
    const auto found = fit_sphere(sums, beta)->project(start - place);
    place += found->position;
    normal = found->normal;
    weight = sums.w;
  }
  return {glm::vec3(place), glm::vec3(normal), static_cast<float>(weight)};
}

std::vector<float> all(const PointCloud& cloud, float radius) {
  return std::vector<float>(cloud.size(), radius);
}

bool equal(const SurfaceSample& a, const SurfaceSample& b) {
  return a.position == b.position && a.normal == b.normal && a.weight == b.weight;
}

TEST(PointSurface, agrees_with_sums_over_all_points) {
  const PointCloud cloud = rough_sphere(3000, 0.02);
  const PointSurface surface(cloud);
  std::vector<float> radii = all(cloud, kRadius);
  // Neighbours with very different radii, too.
  for (std::size_t i = 0; i < radii.size(); i += 3) radii[i] = 0.02f + 0.0003f * float(i % 2000);
  for (const int steps : {1, 3}) {
    const std::vector<SurfaceSample> samples = surface.project(radii, 0.7, steps);
    for (std::size_t i = 0; i < samples.size(); i += 11) {
      const SurfaceSample slow = slow_sample(cloud, surface.order()[i].index, radii[i], 0.7, steps);
      EXPECT_NEAR(samples[i].weight, slow.weight, 1e-3 * slow.weight);
      EXPECT_LT(glm::distance(samples[i].position, slow.position), 1e-5f) << i;
      EXPECT_LT(glm::distance(samples[i].normal, slow.normal), 1e-4f) << i;
    }
  }
}

TEST(PointSurface, is_the_same_to_the_bit_on_every_processor_and_with_any_executor) {
  const PointCloud cloud = rough_sphere(5000, 0.02);
  const PointSurface surface(cloud);
  const std::vector<SurfaceSample> expected = surface.project(all(cloud, kRadius), 1.0, 2);
  const std::vector<SurfaceEvidence> measured = surface.measure(all(cloud, kRadius), 1.0, 1);
  set_cpu_feature_mask(0);
  const std::vector<SurfaceSample> portable = surface.project(all(cloud, kRadius), 1.0, 2);
  const std::vector<SurfaceEvidence> also_measured = surface.measure(all(cloud, kRadius), 1.0, 1);
  set_cpu_feature_mask(~0u);
  const std::vector<SurfaceSample> parallel =
      surface.project(all(cloud, kRadius), 1.0, 2, tbb_executor());
  EXPECT_TRUE(std::ranges::equal(expected, portable, equal));
  EXPECT_TRUE(std::ranges::equal(expected, parallel, equal));
  EXPECT_TRUE(std::ranges::equal(
      measured, also_measured, [](const SurfaceEvidence& a, const SurfaceEvidence& b) {
        return a.square == b.square && a.weight == b.weight && a.extent == b.extent;
      }));
}

TEST(PointSurface, fits_normals_to_positions_when_those_of_the_points_are_poor) {
  PointCloud cloud = rough_sphere(20'000, 0.002);
  std::mt19937 random(2);
  std::normal_distribution<float> normal;
  for (glm::vec3& n : cloud.normals) {
    n = glm::normalize(n + 0.5f * glm::vec3(normal(random), normal(random), normal(random)));
  }
  PointSurface surface(cloud);
  surface.fit_normals(all(cloud, 0.1f));
  double degrees = 0.0;
  for (const SurfaceSample& sample : surface.project(all(cloud, 0.01f), 1.0, 1)) {
    const float cosine = glm::dot(sample.normal, glm::normalize(sample.position));
    degrees += 57.3 * std::acos(std::min(cosine, 1.0f)) / static_cast<double>(cloud.size());
  }
  EXPECT_LT(degrees, 2.5);
}

TEST(PointSurface, measures_how_far_points_extend_along_the_surface) {
  // Curves 0.1 apart.
  PointCloud cloud;
  for (int line = 0; line < 20; ++line) {
    for (int i = 0; i < 400; ++i) {
      cloud.positions.emplace_back(0.005f * float(i), 0.0f, 0.1f * float(line));
      cloud.normals.emplace_back(0.0f, 1.0f, 0.0f);
    }
  }
  const PointSurface surface(cloud);
  const auto median_extent = [&](float radius) {
    std::vector<float> extents;
    for (const SurfaceEvidence& evidence : surface.measure(all(cloud, radius), 1.0, 4)) {
      if (evidence.weight > 0.0f) extents.push_back(evidence.extent);
    }
    EXPECT_NEAR(double(extents.size()), 2000.0, 100.0) << "one in four was asked for";
    std::ranges::nth_element(extents, extents.begin() + std::ssize(extents) / 2);
    return extents[extents.size() / 2];
  };
  EXPECT_LT(median_extent(0.09f), 1e-6f) << "a single curve";
  EXPECT_NEAR(median_extent(0.35f), 1.0f / 12.0f, 0.01f) << "many curves";
}

TEST(SecondMoments, have_the_axes_of_the_points) {
  PlaceSums sums;
  PlaceMoments moments;
  const auto add = [&](const glm::vec3& p) {
    sums.w[3] += 1.0f;
    sums.px[3] += p.x;
    sums.py[3] += p.y;
    sums.pz[3] += p.z;
    moments.xx[3] += p.x * p.x;
    moments.yy[3] += p.y * p.y;
    moments.zz[3] += p.z * p.z;
    moments.xy[3] += p.x * p.y;
    moments.yz[3] += p.y * p.z;
    moments.zx[3] += p.z * p.x;
  };
  const auto axis = [&] {
    const SphereSums s = sums.at(3);
    return SecondMoments(moments, 3).around(s.p, s.w).least_axis({-0.3, -1.0, 0.2});
  };
  const glm::vec3 shift(5.0f, 2.0f, 1.0f);
  for (const float x : {-1.0f, 0.0f, 1.0f}) add(shift + x * glm::vec3(1.0f, 0.0f, 1.0f));
  EXPECT_FALSE(axis()) << "a line has no plane";
  for (const float x : {-1.0f, 0.0f, 1.0f}) add(shift + x * glm::vec3(2.0f, 0.0f, -2.0f));
  ASSERT_TRUE(axis());
  EXPECT_LT(glm::distance(*axis(), glm::dvec3(0.0, -1.0, 0.0)), 1e-5);
}

TEST(PointSurface, keeps_sheets_apart_that_face_away_from_each_other) {
  PointCloud cloud;
  for (int x = 0; x < 60; ++x) {
    for (int z = 0; z < 60; ++z) {
      for (const float side : {-1.0f, 1.0f}) {
        cloud.positions.emplace_back(0.01f * float(x), 0.004f * side, 0.01f * float(z));
        cloud.normals.emplace_back(0.0f, side, 0.0f);
      }
    }
  }
  const PointSurface surface(cloud);
  for (const SurfaceSample& sample : surface.project(all(cloud, 0.05f), 1.0, 3)) {
    EXPECT_NEAR(sample.position.y, 0.004f * sample.normal.y, 1e-6f);
  }
}

TEST(PointSurface, points_without_a_normal_take_no_part) {
  PointCloud cloud = rough_sphere(3000, 0.0);
  for (std::size_t i = 0; i < cloud.size(); i += 2) {
    cloud.normals[i] = glm::vec3(0.0f);
    cloud.positions[i] *= 1.05f;
  }
  const PointSurface surface(cloud);
  const std::vector<SurfaceSample> samples = surface.project(all(cloud, kRadius), 1.0, 2);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (surface.order()[i].index % 2 == 0) {
      EXPECT_EQ(samples[i].weight, 0.0f);
    } else {
      EXPECT_NEAR(glm::length(samples[i].position), 1.0f, 1e-4f);
    }
  }
}

TEST(PointSurface, a_radius_of_zero_leaves_a_point_out) {
  const PointCloud cloud = rough_sphere(1000, 0.0);
  const PointSurface surface(cloud);
  std::vector<float> radii = all(cloud, kRadius);
  radii[5] = 0.0f;
  const std::vector<SurfaceSample> samples = surface.project(radii, 1.0, 1);
  EXPECT_EQ(samples[5].weight, 0.0f);
  EXPECT_GT(samples[6].weight, 0.0f);
}

TEST(PointSurface, many_points_on_one_spot_take_bounded_work) {
  PointCloud cloud = rough_sphere(200'000, 0.0);
  std::fill(cloud.positions.begin() + 1000, cloud.positions.end(), cloud.positions[0]);
  std::fill(cloud.normals.begin() + 1000, cloud.normals.end(), cloud.normals[0]);
  const PointSurface surface(cloud);
  const std::vector<float> radii = surface.radii_of(50.0);
  EXPECT_TRUE(std::ranges::all_of(radii, [](float radius) { return radius > 0.0f; }));
  for (const SurfaceSample& sample : surface.project(all(cloud, kRadius), 1.0, 1)) {
    EXPECT_NEAR(glm::length(sample.position), 1.0f, 2e-2f);
  }
}

TEST(PointSurface, radii_hold_about_as_many_points_as_asked_for) {
  const PointCloud cloud = rough_sphere(20'000, 0.0);
  const std::vector<float> radii = PointSurface(cloud).radii_of(50.0);
  const float exact = std::sqrt(4.0f * 50.0f / 20'000.0f);  // of a flat disc
  const float mean = std::accumulate(radii.begin(), radii.end(), 0.0f) / float(radii.size());
  EXPECT_NEAR(mean, exact, 0.3f * exact);
}

TEST(PointSurface, means_are_those_of_the_points_nearby) {
  const PointCloud cloud = rough_sphere(20'000, 0.0);
  const PointSurface surface(cloud);
  std::vector<glm::vec3> values(cloud.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const glm::vec3 value = 2.0f + cloud.positions[surface.order()[i].index];
    values[i] = i % 7 == 0 ? glm::vec3(-1.0f) : value;
  }
  const std::vector<glm::vec3> means = surface.local_means(values, 30);
  for (std::size_t i = 0; i < means.size(); ++i) {
    const glm::vec3 value = 2.0f + cloud.positions[surface.order()[i].index];
    EXPECT_LT(glm::distance(means[i], value), 0.3f);
  }
}

TEST(PointSurface, of_no_points_is_empty) {
  const PointSurface surface{PointCloud()};
  EXPECT_TRUE(surface.order().empty());
  EXPECT_TRUE(surface.radii_of(50.0).empty());
  EXPECT_TRUE(surface.project({}, 1.0, 2).empty());
  EXPECT_TRUE(surface.measure({}, 1.0, 1).empty());
  EXPECT_TRUE(surface.local_means({}, 10).empty());
}

}  // namespace
}  // namespace pointreel::point_surface_test
