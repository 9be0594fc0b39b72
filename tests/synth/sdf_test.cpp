#include "datasets_synthetic/sdf.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "datasets_synthetic/random.h"

namespace pointreel::sdf_test {
namespace {

constexpr double kTurn = 6.283185307179586;

glm::dvec3 unit(const glm::dvec3& v) { return v / std::sqrt(glm::dot(v, v)); }

glm::dmat3 some_rotation() {
  const glm::dvec3 a = unit({1.0, 2.0, -0.5});
  const glm::dvec3 b = unit(glm::cross(a, glm::dvec3(0.3, -1.0, 0.8)));
  return {a, b, glm::cross(a, b)};
}

RoundCone some_cone() { return {{0.1, -0.2, 0.05}, {0.3, 0.25, -0.1}, 0.12, 0.05}; }

Ellipsoid some_ellipsoid() { return {{0.05, 0.1, -0.02}, some_rotation(), {0.3, 0.12, 0.06}}; }

/// Signed distance to the hull of two balls by definition: the hull is the union of the balls whose
/// centre and radius are interpolated between the two.
double slow_distance(const RoundCone& cone, const glm::dvec3& p) {
  constexpr int kSteps = 200000;
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kSteps; ++i) {
    const double t = static_cast<double>(i) / kSteps;
    const glm::dvec3 center = cone.a + t * (cone.b - cone.a);
    const double radius = cone.radius_a + t * (cone.radius_b - cone.radius_a);
    nearest = std::min(nearest, glm::length(p - center) - radius);
  }
  return nearest;
}

template <class Function>
void for_points_on(const Ellipsoid& ellipsoid, const Function& function) {
  constexpr int kRings = 700;
  std::vector<glm::dvec2> circle;
  for (int j = 0; j < 2 * kRings; ++j) {
    const double around = kTurn * j / (2 * kRings);
    circle.emplace_back(std::cos(around), std::sin(around));
  }
  const glm::dmat3 axes(ellipsoid.axes[0] * ellipsoid.radii.x,
                        ellipsoid.axes[1] * ellipsoid.radii.y,
                        ellipsoid.axes[2] * ellipsoid.radii.z);
  for (int i = 0; i <= kRings; ++i) {
    const double polar = 0.5 * kTurn * i / kRings;
    const double ring = std::sin(polar);
    const glm::dvec3 center = ellipsoid.center + axes[2] * std::cos(polar);
    for (const glm::dvec2& at : circle) function(center + (axes[0] * at.x + axes[1] * at.y) * ring);
  }
}

/// Unsigned distance to an ellipsoid, from points all over its surface.
double slow_distance(const Ellipsoid& ellipsoid, const glm::dvec3& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for_points_on(ellipsoid, [&](const glm::dvec3& on) {
    nearest = std::min(nearest, glm::dot(p - on, p - on));
  });
  return std::sqrt(nearest);
}

glm::dvec3 random_point(Random& random, double reach) {
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  return reach * (2.0 * glm::dvec3(x, y, z) - 1.0);
}

template <class Function>
glm::dvec3 finite_difference(const Function& value, const glm::dvec3& p) {
  constexpr double kStep = 1e-6;
  glm::dvec3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 step(0.0);
    step[axis] = kStep;
    gradient[axis] = (value(p + step) - value(p - step)) / (2.0 * kStep);
  }
  return gradient;
}

Disc some_disc() { return {{0.05, 0.1, -0.02}, some_rotation()[1], 0.3, 0.06}; }

TEST(Sdf, the_distance_to_a_disc_is_that_to_the_nearest_of_many_balls_on_it) {
  Random random(6, 0);
  const Disc disc = some_disc();
  const glm::dvec3 x = unit(glm::cross(disc.axis, {0.2, 0.3, 1.0}));
  const glm::dvec3 z = glm::cross(x, disc.axis);
  constexpr int kSteps = 600;
  for (int i = 0; i < 40; ++i) {
    const glm::dvec3 p = disc.center + random_point(random, 0.45);
    double nearest = std::numeric_limits<double>::infinity();
    for (int j = 0; j <= kSteps; ++j) {
      for (int k = 0; k < kSteps; ++k) {
        const double around = kTurn * k / kSteps;
        const glm::dvec3 out = std::cos(around) * x + std::sin(around) * z;
        nearest = std::min(nearest, glm::length(p - disc.center - disc.radius * j / kSteps * out) -
                                        disc.thickness);
      }
    }
    const Distance at = distance_to(disc, p);
    EXPECT_NEAR(at.value, nearest, 3e-4);  // the balls are up to 3 mm apart
    EXPECT_NEAR(glm::length(at.gradient), 1.0, 1e-12);
    EXPECT_NEAR(distance_to(disc, p - at.value * at.gradient).value, 0.0, 1e-12);
  }
  EXPECT_NEAR(distance_to(disc, disc.center).value, -disc.thickness, 1e-12);
  EXPECT_NEAR(distance_to(disc, disc.center + 0.5 * x).value, 0.2 - disc.thickness, 1e-12);
}

TEST(Sdf, blends_skip_far_ellipsoids_without_changing_the_distance) {
  Random random(7, 0);
  Surface surface;
  surface.primitives = {some_cone(), some_ellipsoid()};
  surface.blends = {{0, 1, 0.05}};
  int far = 0;
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 p = random_point(random, 0.8);
    const Distance cone = distance_to(surface.primitives[0], p);
    const Distance ellipsoid = distance_to(surface.primitives[1], p);
    const Distance full = smooth_union(cone, ellipsoid, 0.05);
    EXPECT_EQ(distance_to(surface, p).distance.value, full.value);
    EXPECT_EQ(distance_to(surface, p).distance.gradient, full.gradient);
    far += ellipsoid.value - cone.value > 0.05;
  }
  EXPECT_GT(far, 50);
}

TEST(Sdf, the_distance_to_a_round_cone_is_that_to_the_nearest_of_its_balls) {
  Random random(1, 0);
  const RoundCone cone = some_cone();
  for (int i = 0; i < 100; ++i) {
    const glm::dvec3 p = random_point(random, 0.6);
    EXPECT_NEAR(distance_to(cone, p).value, slow_distance(cone, p), 1e-8);
  }
}

TEST(Sdf, a_round_cone_is_a_ball_if_one_end_contains_the_other) {
  const RoundCone first{{0, 0, 0}, {0.1, 0, 0}, 0.5, 0.2};
  const RoundCone second{{0.1, 0, 0}, {0, 0, 0}, 0.2, 0.5};
  EXPECT_DOUBLE_EQ(distance_to(first, {2, 0, 0}).value, 1.5);
  EXPECT_DOUBLE_EQ(distance_to(second, {2, 0, 0}).value, 1.5);
}

TEST(Sdf, the_distance_to_an_ellipsoid_is_that_to_its_nearest_point) {
  Random random(2, 0);
  const Ellipsoid ellipsoid = some_ellipsoid();
  for (int i = 0; i < 40; ++i) {
    const glm::dvec3 p = ellipsoid.center + random_point(random, 0.4);
    const double value = distance_to(ellipsoid, p).value;
    EXPECT_NEAR(std::abs(value), slow_distance(ellipsoid, p), 2e-3);  // the points are 1.4 mm apart
    const glm::dvec3 scaled =
        glm::transpose(ellipsoid.axes) * (p - ellipsoid.center) / ellipsoid.radii;
    EXPECT_EQ(value < 0.0, glm::dot(scaled, scaled) < 1.0);
  }
}

TEST(Sdf, a_step_by_the_distance_to_an_ellipsoid_ends_on_it) {
  Random random(3, 0);
  const Ellipsoid ellipsoid = some_ellipsoid();
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 p = ellipsoid.center + random_point(random, 0.4);
    const Distance at = distance_to(ellipsoid, p);
    EXPECT_NEAR(glm::length(at.gradient), 1.0, 1e-12);
    const glm::dvec3 scaled = glm::transpose(ellipsoid.axes) *
                              (p - at.value * at.gradient - ellipsoid.center) / ellipsoid.radii;
    EXPECT_NEAR(glm::dot(scaled, scaled), 1.0, 1e-8);
  }
}

TEST(Sdf, the_distance_is_defined_even_if_the_nearest_point_is_not_unique) {
  const Ellipsoid ellipsoid{{0, 0, 0}, glm::dmat3(1.0), {0.3, 0.2, 0.1}};
  EXPECT_NEAR(distance_to(ellipsoid, {0, 0, 0}).value, -0.1, 1e-6);
  EXPECT_NEAR(glm::length(distance_to(ellipsoid, {0, 0, 0}).gradient), 1.0, 1e-9);
  const Ellipsoid ball{{0, 0, 0}, glm::dmat3(1.0), {0.2, 0.2, 0.2}};
  EXPECT_NEAR(distance_to(ball, {0, 0, 0}).value, -0.2, 1e-6);
  EXPECT_NEAR(distance_to(ball, {0, 1, 0}).value, 0.8, 1e-12);
  const Distance axis = distance_to(RoundCone{{0, 0, 0}, {0, 1, 0}, 0.1, 0.1}, {0, 0.5, 0});
  EXPECT_NEAR(axis.value, -0.1, 1e-12);
  EXPECT_NEAR(glm::length(axis.gradient), 1.0, 1e-12);
}

TEST(Sdf, gradients_agree_with_finite_differences) {
  Random random(4, 0);
  const RoundCone cone = some_cone();
  const Ellipsoid ellipsoid = some_ellipsoid();
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 p = random_point(random, 0.6);
    const auto blended = [&](const glm::dvec3& q) {
      return smooth_union(distance_to(cone, q), distance_to(ellipsoid, q), 0.1).value;
    };
    const Distance at = smooth_union(distance_to(cone, p), distance_to(ellipsoid, p), 0.1);
    if (distance_to(ellipsoid, p).value < -0.01 || distance_to(cone, p).value < -0.02) continue;
    EXPECT_LT(glm::length(at.gradient - finite_difference(blended, p)), 1e-5);
    EXPECT_LE(glm::length(at.gradient), 1.0 + 1e-12);
  }
}

TEST(Sdf, a_smooth_union_is_symmetric_and_never_farther_than_the_sharp_one) {
  Random random(5, 0);
  const RoundCone cone = some_cone();
  const Ellipsoid ellipsoid = some_ellipsoid();
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 p = random_point(random, 0.5);
    const Distance a = distance_to(cone, p), b = distance_to(ellipsoid, p);
    const double sharp = std::min(a.value, b.value);
    EXPECT_EQ(smooth_union(a, b, 0.0).value, sharp);
    const double smooth = smooth_union(a, b, 0.08).value;
    EXPECT_DOUBLE_EQ(smooth, smooth_union(b, a, 0.08).value);
    EXPECT_LE(smooth, sharp);
    EXPECT_GE(smooth, sharp - 0.02);
  }
}

TEST(Sdf, bounds_agree_with_many_points_on_the_primitive) {
  const Ellipsoid ellipsoid = some_ellipsoid();
  Box of_points;
  for_points_on(ellipsoid, [&](const glm::dvec3& p) { of_points.grow(p); });
  const Box box = bounds(Primitive(ellipsoid));
  EXPECT_LT(glm::length(box.min - of_points.min), 1e-5);
  EXPECT_LT(glm::length(box.max - of_points.max), 1e-5);

  Box of_disc;
  const Disc disc = some_disc();
  const glm::dvec3 x = unit(glm::cross(disc.axis, {0.2, 0.3, 1.0}));
  const glm::dvec3 z = glm::cross(x, disc.axis);
  for (int i = 0; i < 100000; ++i) {
    const double around = kTurn * i / 100000;
    const glm::dvec3 rim =
        disc.center + disc.radius * (std::cos(around) * x + std::sin(around) * z);
    of_disc.grow(rim - disc.thickness);
    of_disc.grow(rim + disc.thickness);
  }
  EXPECT_LT(glm::length(bounds(Primitive(disc)).min - of_disc.min), 1e-6);
  EXPECT_LT(glm::length(bounds(Primitive(disc)).max - of_disc.max), 1e-6);

  const Box cone = bounds(Primitive(RoundCone{{0, 1, 0}, {1, 1.5, 0}, 0.5, 0.25}));
  EXPECT_EQ(cone.min, glm::dvec3(-0.5, 0.5, -0.5));
  EXPECT_EQ(cone.max, glm::dvec3(1.25, 1.75, 0.5));
}

TEST(Sdf, parts_without_a_common_blend_do_not_merge) {
  Surface surface;
  surface.primitives = {RoundCone{{0, 0, 0}, {0, 1, 0}, 0.1, 0.1},
                        RoundCone{{0.22, 0, 0}, {0.22, 1, 0}, 0.1, 0.1}};
  surface.blends = {{0, 0, 0.0}, {1, 1, 0.0}};
  EXPECT_NEAR(distance_to(surface, {0.11, 0.5, 0}).distance.value, 0.01, 1e-12);
  surface.blends = {{0, 1, 0.08}};
  EXPECT_NEAR(distance_to(surface, {0.11, 0.5, 0}).distance.value, 0.01 - 0.02, 1e-12);
  EXPECT_EQ(distance_to(surface, {0.21, 0.5, 0}).primitive, 1);
}

TEST(Sdf, distances_to_several_blends_equal_those_to_each_alone) {
  Surface surface;
  surface.primitives = {some_cone(), some_ellipsoid(), RoundCone{{0, 0, 0}, {0, 1, 0}, 0.1, 0.2}};
  surface.blends = {{0, 1, 0.05}, {1, 2, 0.02}, {2, 2, 0.0}};
  const std::vector<std::uint16_t> some = {2, 0, 1};
  std::vector<double> values(3);
  const glm::dvec3 p(0.2, 0.3, 0.25);
  const double nearest = blend_distances(surface, some, p, values);
  for (std::size_t i = 0; i < some.size(); ++i) {
    Surface alone = surface;
    alone.blends = {surface.blends[some[i]]};
    EXPECT_EQ(values[i], distance_to(alone, p).distance.value);
  }
  EXPECT_EQ(nearest, *std::min_element(values.begin(), values.end()));
  EXPECT_EQ(nearest, distance_to(surface, p).distance.value);
}

}  // namespace
}  // namespace pointreel::sdf_test
