#include "codec/distance/distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "codec/distance/nearest.h"

namespace pointreel::distance_test {
namespace {

PointCloud random_cloud(std::size_t n, unsigned seed, const glm::dvec3& origin) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
  PointCloud cloud;
  cloud.origin = origin;
  for (std::size_t i = 0; i < n; ++i) {
    cloud.positions.emplace_back(uniform(random), uniform(random), uniform(random));
  }
  return cloud;
}

OneWayDistance brute_force(const PointCloud& from, const PointCloud& to) {
  OneWayDistance result;
  for (std::size_t i = 0; i < from.size(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < to.size(); ++k) {
      nearest = std::min(nearest, glm::length(from.world(i) - to.world(k)));
    }
    result.mean_squared += nearest * nearest / static_cast<double>(from.size());
    result.max = std::max(result.max, nearest);
  }
  return result;
}

TEST(Distance, agrees_with_brute_force_for_any_origins) {
  for (const double offset : {0.0, 1e6}) {
    const PointCloud a = random_cloud(700, 1, glm::dvec3(offset, -offset, 0.25));
    const PointCloud b = random_cloud(450, 2, glm::dvec3(offset + 0.5, -offset, 0.0));
    const Result<CloudDistance> distance = cloud_distance(a, b);
    ASSERT_TRUE(distance.has_value());
    const OneWayDistance ab = brute_force(a, b), ba = brute_force(b, a);
    EXPECT_NEAR(distance->a_to_b.mean_squared, ab.mean_squared, 1e-8);
    EXPECT_NEAR(distance->b_to_a.mean_squared, ba.mean_squared, 1e-8);
    EXPECT_NEAR(distance->a_to_b.max, ab.max, 1e-8);
    EXPECT_NEAR(distance->b_to_a.max, ba.max, 1e-8);
    EXPECT_NE(ab.max, ba.max);
    EXPECT_EQ(distance->d1(),
              std::max(distance->a_to_b.mean_squared, distance->b_to_a.mean_squared));
    EXPECT_EQ(distance->max(), std::max(distance->a_to_b.max, distance->b_to_a.max));
  }
}

TEST(Distance, is_zero_from_a_cloud_to_itself) {
  PointCloud cloud = random_cloud(100, 3, glm::dvec3(5.0));
  cloud.positions.push_back(cloud.positions.front());
  const Result<CloudDistance> distance = cloud_distance(cloud, cloud);
  ASSERT_TRUE(distance.has_value());
  EXPECT_EQ(distance->d1(), 0.0);
  EXPECT_EQ(distance->max(), 0.0);
  EXPECT_EQ(geometry_psnr(distance->d1(), 1023.0), std::numeric_limits<double>::infinity());
}

TEST(Distance, detects_a_point_that_only_one_cloud_has) {
  PointCloud a, b;
  a.positions = {{0, 0, 0}, {0, 1, 0}};
  b.positions = {{0, 0, 0}, {0, 1, 0}, {3, 0, 4}, {0, 1, 0}};
  const Result<CloudDistance> distance = cloud_distance(a, b);
  ASSERT_TRUE(distance.has_value());
  EXPECT_EQ(distance->a_to_b.mean_squared, 0.0);
  EXPECT_EQ(distance->d1(), 25.0 / 4.0);
  EXPECT_EQ(distance->max(), 5.0);
}

TEST(Distance, gives_the_peak_ratio_that_mpeg_defines) {
  EXPECT_NEAR(geometry_psnr(1.0, 1023.0), 64.97, 0.01);
  EXPECT_NEAR(geometry_psnr(3.0, 1.0), 0.0, 1e-12);
}

TEST(Distance, is_an_error_for_a_cloud_without_points) {
  const PointCloud cloud = random_cloud(3, 4, glm::dvec3(0.0));
  EXPECT_FALSE(cloud_distance(cloud, {}).has_value());
  EXPECT_FALSE(cloud_distance({}, cloud).has_value());
}

// --- nearest neighbours ---

TEST(NearestPoints, are_exactly_those_that_brute_force_finds) {
  // On a small lattice, almost every point in between has several nearest neighbours, up to eight.
  std::mt19937 random(5);
  std::vector<glm::dvec3> points, queries;
  for (int i = 0; i < 150; ++i) {
    points.emplace_back(random() % 8, random() % 8, random() % 8);
    queries.emplace_back(0.5 * static_cast<double>(random() % 16),
                         0.5 * static_cast<double>(random() % 16),
                         0.5 * static_cast<double>(random() % 16));
  }
  for (const double tolerance : {0.0, 1e-9, 0.3}) {
    const NearestPoints nearest = nearest_points(queries, points, tolerance);
    std::size_t most = 0;
    for (std::size_t i = 0; i < queries.size(); ++i) {
      double best = std::numeric_limits<double>::infinity();
      for (const glm::dvec3& p : points) best = std::min(best, glm::distance(queries[i], p));
      std::vector<std::uint32_t> expected;
      for (std::uint32_t k = 0; k < points.size(); ++k) {
        if (glm::distance(queries[i], points[k]) <= best + tolerance) expected.push_back(k);
      }
      const auto found = nearest.of(i);
      EXPECT_EQ(std::vector<std::uint32_t>(found.begin(), found.end()), expected);
      EXPECT_NEAR(std::sqrt(nearest.squared_distances[i]), best, 1e-12);
      most = std::max(most, expected.size());
    }
    EXPECT_GE(most, 4u);
  }
}

TEST(NearestPoints, are_bounded_in_number_if_very_many_are_equally_near) {
  std::vector<glm::dvec3> points(100'000, glm::dvec3(1.0));
  points.push_back(glm::dvec3(0.5));
  const NearestPoints nearest = nearest_points(std::vector(3, glm::dvec3(2.0)), points, 0.0);
  EXPECT_EQ(nearest.of(2).size(), kMaxEquallyNear);
  EXPECT_EQ(nearest.squared_distances[2], 3.0);
}

TEST(DistinctPoints, have_every_position_once_and_every_point_as_a_member) {
  PointCloud cloud = random_cloud(200, 6, glm::dvec3(1e6, 0.0, 0.0));
  for (std::size_t i = 0; i < 100; ++i) cloud.positions.push_back(cloud.positions[i / 2]);
  const Cube cube = bounding_cube(bounds(cloud));
  const DistinctPoints distinct = distinct_points(cloud, cube);
  ASSERT_EQ(distinct.size(), 200u);
  std::vector<int> seen(cloud.size());
  for (std::size_t i = 0; i < distinct.size(); ++i) {
    for (const std::uint32_t member : distinct.at(i)) {
      ++seen[member];
      EXPECT_LT(glm::distance(cube.origin + distinct.positions[i], cloud.world(member)), 1e-9);
    }
  }
  EXPECT_EQ(seen, std::vector<int>(cloud.size(), 1));
}

// --- cases with known answers ---

constexpr float kStep = 1.0f / 16.0f;

/// A square of 16 x 16 points at height z that faces up, moved sideways.
PointCloud plane(float z, float sideways = 0.0f) {
  PointCloud cloud;
  for (int i = 0; i < 256; ++i) {
    const float x = static_cast<float>(i % 16), y = static_cast<float>(i / 16);
    cloud.positions.emplace_back(x * kStep + sideways, y * kStep, z);
    cloud.normals.emplace_back(0, 0, 1);
    cloud.colors.push_back(glm::u16vec3(100, 120, 140) * std::uint16_t{257});
  }
  return cloud;
}

CloudDistance measure(const PointCloud& a, const PointCloud& b) {
  const auto distance = cloud_distance(a, b);
  EXPECT_TRUE(distance.has_value());
  return distance.value_or(CloudDistance{});
}

TEST(PlaneDistance, equals_the_point_distance_for_a_plane_moved_along_its_normal) {
  const CloudDistance distance = measure(plane(0.0f), plane(0.25f));
  EXPECT_EQ(distance.d1(), 0.0625);
  EXPECT_EQ(distance.d2().value(), 0.0625);
  EXPECT_EQ(distance.max(), 0.25);
}

TEST(PlaneDistance, is_zero_for_a_plane_moved_sideways) {
  const float shift = kStep / 4.0f;
  const CloudDistance distance = measure(plane(0.0f), plane(0.0f, shift));
  EXPECT_EQ(distance.d1(), static_cast<double>(shift * shift));
  EXPECT_EQ(distance.d2().value(), 0.0);
}

TEST(PlaneDistance, uses_the_normals_of_the_reference_cloud) {
  PointCloud a = plane(0.0f), b = plane(0.25f);
  b.normals.assign(b.size(), glm::vec3(1, 0, 0));
  EXPECT_EQ(measure(a, b).d2().value(), 0.0625);
  b.normals.clear();
  EXPECT_EQ(measure(a, b).d2().value(), 0.0625);
  EXPECT_EQ(measure(b, a).d2().value(), 0.0625);  // only a has normals
  a.normals.clear();
  EXPECT_FALSE(measure(a, b).d2());
}

TEST(PlaneDistance, skips_and_counts_points_without_a_normal) {
  PointCloud a = plane(0.0f), b = plane(0.25f);
  for (std::size_t i = 0; i < 64; ++i) a.normals[i] = glm::vec3(0);
  CloudDistance distance = measure(a, b);
  EXPECT_EQ(distance.a_to_b.plane_unknown, 64u);
  EXPECT_EQ(distance.b_to_a.plane_unknown, 64u);
  EXPECT_EQ(distance.d2().value(), 0.0625);
  a.normals.assign(a.size(), glm::vec3(0));
  distance = measure(a, b);
  EXPECT_EQ(distance.a_to_b.plane_unknown, 256u);
  EXPECT_FALSE(distance.d2());
}

TEST(PlaneDistance, uses_the_mean_normal_of_equally_near_points) {
  PointCloud a, b;
  a.positions = {{-1, 0, 0}, {1, 0, 0}};
  a.normals = {{0.6f, 0.8f, 0}, {-0.6f, 0.8f, 0}};
  b.positions = {{0, 2, 0}};
  const CloudDistance distance = measure(a, b);
  EXPECT_NEAR(distance.a_to_b.plane_mean_squared.value(), 4.0, 1e-6);        // along (0, 1, 0)
  EXPECT_NEAR(distance.b_to_a.plane_mean_squared.value(), 2.2 * 2.2, 1e-6);  // both equally near
}

TEST(ColorDistance, is_measured_in_the_luma_and_chroma_of_bt_709) {
  PointCloud a = plane(0.0f), b = a;
  for (glm::u16vec3& c : b.colors) c += glm::u16vec3(10, 10, 10) * std::uint16_t{257};
  ColorError error = measure(a, b).colors().value();
  EXPECT_NEAR(error.x, 100.0, 1e-9);
  EXPECT_NEAR(error.y, 0.0, 1e-20);
  EXPECT_NEAR(error.z, 0.0, 1e-20);
  EXPECT_NEAR(color_psnr(error).x, 28.13, 0.01);
  EXPECT_NEAR(yuv_psnr({40.0, 36.0, 44.0}), 40.0, 1e-12);
  EXPECT_NEAR(yuv_psnr({32.0, 40.0, 40.0}), 34.0, 1e-12);

  b.colors = a.colors;
  for (glm::u16vec3& c : b.colors) c.b = static_cast<std::uint16_t>(c.b + 10 * 257);
  error = measure(a, b).colors().value();
  EXPECT_NEAR(std::sqrt(error.x), 0.722, 1e-9);
  EXPECT_NEAR(std::sqrt(error.y), 5.0, 1e-9);  // half of 10 (1 - 0.0722) / 0.9278
  EXPECT_NEAR(std::sqrt(error.z), 0.722 / 1.5748, 1e-9);

  b.colors.clear();
  EXPECT_FALSE(measure(a, b).colors());
}

TEST(ColorDistance, uses_the_mean_colour_of_equally_near_points) {
  PointCloud a, b;
  a.positions = {{0, 0, 0}};
  a.colors = {glm::u16vec3(50 * 257)};
  b.positions = {{-1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 3, 0}};
  b.colors = {glm::u16vec3(40 * 257), glm::u16vec3(50 * 257), glm::u16vec3(70 * 257),
              glm::u16vec3(255 * 257)};
  // The mean colour is 40 at one place and 60 at the other.
  EXPECT_NEAR(measure(a, b).a_to_b.colors->x, 0.0, 1e-20);
  // This neighbour is farther by the last bit of a float, as rounding can make it.
  b.positions[0].x = std::nextafter(-1.0f, -2.0f);
  EXPECT_NEAR(measure(a, b).a_to_b.colors->x, 0.0, 1e-20);
}

TEST(ColorDistance, is_the_worse_of_both_directions_if_symmetric) {
  PointCloud a = plane(0.0f), b = a;
  b.positions.push_back({0, 0, 1});
  b.colors.push_back(glm::u16vec3(0));
  b.normals.push_back({0, 0, -1});
  const CloudDistance distance = measure(a, b);
  EXPECT_EQ(distance.a_to_b.colors->x, 0.0);
  EXPECT_GT(distance.b_to_a.colors->x, 0.0);
  EXPECT_EQ(distance.colors()->x, distance.b_to_a.colors->x);
  EXPECT_NEAR(distance.normals()->mean, std::numbers::pi / 257.0, 1e-12);
  EXPECT_EQ(distance.normals()->percentile_95, 0.0);
}

TEST(NormalDistance, equals_the_angle_by_which_normals_are_tilted) {
  for (const double angle : {1e-4, 0.1, 1.0, 3.0}) {
    const PointCloud a = plane(0.0f);
    PointCloud b = a;
    for (std::size_t i = 0; i < b.size(); ++i) {
      b.normals[i] =
          glm::vec3(static_cast<float>(std::sin(angle)), 0.0f, static_cast<float>(std::cos(angle)));
    }
    const AngleError error = measure(a, b).normals().value();
    EXPECT_NEAR(error.mean, angle, 1e-6);
    EXPECT_NEAR(error.percentile_95, angle, 1e-6);
    EXPECT_EQ(error.unknown, 0u);
  }
}

TEST(NormalDistance, skips_and_counts_unknown_normals) {
  const PointCloud a = plane(0.0f);
  PointCloud b = a;
  for (std::size_t i = 0; i < 10; ++i) b.normals[i] = glm::vec3(0);
  const CloudDistance distance = measure(a, b);
  EXPECT_EQ(distance.a_to_b.normals->unknown, 10u);
  EXPECT_EQ(distance.normals()->unknown, 20u);
  EXPECT_EQ(distance.normals()->mean, 0.0);
  b.normals.assign(b.size(), glm::vec3(0));
  EXPECT_FALSE(measure(a, b).normals());
}

// --- the whole measure, computed the slow way ---

/// A point of a cloud without duplicates: the mean of the points at its place.
struct Place {
  glm::dvec3 at{0.0}, normal{0.0}, color{0.0};
  double points = 0.0;
};

std::vector<Place> places(const PointCloud& cloud) {
  std::vector<Place> all;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    auto place = std::find_if(all.begin(), all.end(),
                              [&](const Place& p) { return p.at == cloud.world(i); });
    if (place == all.end()) place = all.insert(all.end(), {cloud.world(i), {}, {}, 0.0});
    place->normal += glm::dvec3(cloud.normals[i]);
    place->color += glm::dvec3(cloud.colors[i]) / 257.0;
    place->points += 1.0;
  }
  for (Place& place : all) {
    place.color /= place.points;
    place.normal = glm::normalize(place.normal);
  }
  return all;
}

std::vector<std::size_t> nearest_of(const glm::dvec3& p, const std::vector<Place>& all) {
  double best = std::numeric_limits<double>::infinity();
  for (const Place& place : all) best = std::min(best, glm::distance(p, place.at));
  std::vector<std::size_t> nearest;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (glm::distance(p, all[i].at) <= best + 1e-7) nearest.push_back(i);
  }
  return nearest;
}

TEST(Distance, agrees_with_brute_force_in_all_metrics_with_ties_and_duplicates) {
  // Both lie on a lattice, with some points twice. That of b is coarser and lies between the points
  // of a.
  std::mt19937 random(9);
  const auto lattice = [&random](std::size_t n, float step, float shift) {
    PointCloud cloud;
    for (std::size_t i = 0; i < n; ++i) {
      const auto one = [&] { return step * static_cast<float>(random() % 8) + shift; };
      cloud.positions.emplace_back(one(), one(), one());
      // The normals point roughly upwards, so that no mean of them vanishes.
      cloud.normals.push_back(glm::normalize(glm::vec3(0.1f * one(), 3.0f, 0.1f * one())));
      cloud.colors.push_back(glm::u16vec3(random() % 256, random() % 256, random() % 256) *
                             std::uint16_t{257});
    }
    return cloud;
  };
  const PointCloud a = lattice(400, 1.0f, 0.0f), b = lattice(60, 2.0f, -0.5f);
  const std::vector<Place> in_a = places(a), in_b = places(b);
  ASSERT_LT(in_a.size(), a.size());
  ASSERT_LT(in_b.size(), b.size());

  // The normals of a, averaged at the places of b.
  std::vector<glm::dvec3> lent(in_b.size(), glm::dvec3(0.0));
  for (const Place& place : in_a) {
    for (const std::size_t k : nearest_of(place.at, in_b)) lent[k] += place.normal;
  }
  for (std::size_t k = 0; k < in_b.size(); ++k) {
    if (lent[k] == glm::dvec3(0.0)) {
      for (const std::size_t i : nearest_of(in_b[k].at, in_a)) lent[k] += in_a[i].normal;
    }
    lent[k] = glm::normalize(lent[k]);
  }
  double squared = 0.0, plane = 0.0, angle = 0.0;
  glm::dvec3 color(0.0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto nearest = nearest_of(a.world(i), in_b);
    const double count = static_cast<double>(nearest.size());
    glm::dvec3 mean_color(0.0), mean_normal(0.0);
    for (const std::size_t k : nearest) {
      const glm::dvec3 off = a.world(i) - in_b[k].at;
      squared += glm::dot(off, off) / count;
      plane += std::pow(glm::dot(off, lent[k]), 2) / count;
      mean_color += in_b[k].color / count;
      mean_normal += in_b[k].normal;
    }
    angle +=
        std::acos(std::min(glm::dot(glm::dvec3(a.normals[i]), glm::normalize(mean_normal)), 1.0));
    const glm::dvec3 c = glm::dvec3(a.colors[i]) / 257.0 - mean_color;
    const double y = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
    color += glm::dvec3(y * y, std::pow((c.b - y) / (2.0 * (1.0 - 0.0722)), 2),
                        std::pow((c.r - y) / (2.0 * (1.0 - 0.2126)), 2));
  }
  const double n = static_cast<double>(a.size());
  const OneWayDistance distance = measure(a, b).a_to_b;
  EXPECT_NEAR(distance.mean_squared, squared / n, 1e-9);
  EXPECT_NEAR(distance.plane_mean_squared.value(), plane / n, 1e-9);
  EXPECT_NEAR(distance.normals->mean, angle / n, 1e-5);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR((*distance.colors)[i], color[i] / n, 1e-9);
}

TEST(Distance, does_not_depend_on_the_number_of_threads_or_the_order_of_points) {
  PointCloud a = random_cloud(6000, 7, glm::dvec3(0.0)), b = random_cloud(5000, 8, glm::dvec3(0.0));
  for (PointCloud* cloud : {&a, &b}) {
    for (glm::vec3& p : cloud->positions) {
      p = glm::round(p * 16.0f) / 16.0f;  // gives duplicates and several neighbours
      cloud->normals.push_back(glm::normalize(p + glm::vec3(0.01f)));
      cloud->colors.push_back(glm::u16vec3((p + 1.0f) * 30000.0f));
    }
  }
  const auto in_threads = [&](int threads) {
    tbb::task_arena arena(threads);
    return arena.execute([&] { return measure(a, b); });
  };
  const CloudDistance one = in_threads(1), four = in_threads(4);
  std::reverse(a.positions.begin(), a.positions.end());
  std::reverse(a.normals.begin(), a.normals.end());
  std::reverse(a.colors.begin(), a.colors.end());
  const CloudDistance turned = measure(a, b);
  const auto expect_equal = [](const OneWayDistance& x, const OneWayDistance& y) {
    EXPECT_EQ(x.mean_squared, y.mean_squared);
    EXPECT_EQ(x.plane_mean_squared, y.plane_mean_squared);
    EXPECT_EQ(x.max, y.max);
    EXPECT_EQ(x.colors, y.colors);
    EXPECT_EQ(x.normals->mean, y.normals->mean);
    EXPECT_EQ(x.normals->percentile_95, y.normals->percentile_95);
  };
  expect_equal(one.a_to_b, four.a_to_b);
  expect_equal(one.b_to_a, four.b_to_a);
  EXPECT_DOUBLE_EQ(one.d1(), turned.d1());
  EXPECT_NEAR(one.d2().value(), turned.d2().value(), 1e-15);
  EXPECT_NEAR(one.colors()->x, turned.colors()->x, 1e-9);
}

TEST(DistanceSummary, has_the_mean_and_percentiles_by_nearest_rank) {
  std::vector<double> distances;
  for (int i = 1; i <= 1000; ++i) distances.push_back((i * 7 % 1000 + 1) * 0.001);
  const DistanceSummary summary = summarize(distances);
  EXPECT_NEAR(summary.mean, 0.5005, 1e-12);
  EXPECT_NEAR(summary.percentile_95, 0.95, 1e-12);
  EXPECT_NEAR(summary.percentile_999, 0.999, 1e-12);
  EXPECT_EQ(summary.max, 1.0);
  EXPECT_EQ(summarize({}).max, 0.0);
  EXPECT_EQ(summarize(std::vector{2.0}).percentile_95, 2.0);
}

}  // namespace
}  // namespace pointreel::distance_test
