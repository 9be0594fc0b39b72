#include "datasets_synthetic/ray_cast.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "datasets_synthetic/body.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/random.h"

namespace pointreel::ray_cast_test {
namespace {

glm::dvec3 unit(const glm::dvec3& v) { return v / std::sqrt(glm::dot(v, v)); }

glm::dvec3 random_direction(Random& random) {
  while (true) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    if (x * x + y * y + z * z > 1e-3) return unit({x, y, z});
  }
}

glm::dvec3 random_point(Random& random, const glm::dvec3& from, const glm::dvec3& to) {
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  return from + (to - from) * glm::dvec3(x, y, z);
}

SurfaceGrid grid_of(const Surface& surface) { return SurfaceGrid::build(surface).value(); }

Surface ball(const glm::dvec3& center, double radius) {
  return {{RoundCone{center, center, radius, radius}}, {{0, 0, 0.0}}};
}

double value_at(const Surface& surface, const glm::dvec3& p) {
  return distance_to(surface, p).distance.value;
}

/// Checks that the hits are on the surface and in order, and that points along the ray are on the
/// side of the surface that the hits imply. Points are taken in steps of their distance, but of at
/// least `step`.
void expect_true(const Surface& surface, const Ray& ray, const std::vector<RayHit>& hits,
                 double length, double step) {
  std::size_t passed = 0;
  double last = 0.0;
  for (const RayHit& hit : hits) {
    EXPECT_GE(hit.t, last);
    last = hit.t;
    EXPECT_EQ(hit.position, ray.at(hit.t));
    EXPECT_LE(std::abs(value_at(surface, hit.position)), 1e-9);
    EXPECT_NEAR(glm::length(hit.normal), 1.0, 1e-12);
    EXPECT_LE((hit.enters ? 1.0 : -1.0) * glm::dot(hit.normal, ray.direction), 1e-3);
  }
  for (double t = 0.0; t < length;) {
    while (passed < hits.size() && hits[passed].t < t) ++passed;
    const double value = value_at(surface, ray.at(t));
    const bool inside = passed > 0 ? hits[passed - 1].enters : !hits.empty() && !hits[0].enters;
    // Within this distance of the surface, rounding decides.
    if (std::abs(value) > 1e-9) {
      EXPECT_EQ(value < 0.0, inside) << "at " << t << " of " << hits.size() << " hits, " << value;
      if ((value < 0.0) != inside) return;
    }
    t += std::max(0.9 * std::abs(value), step);
  }
}

TEST(RayCast, rays_through_a_ball_agree_with_the_formula) {
  const glm::dvec3 center(0.2, 1.1, -0.3);
  const double radius = 0.11;
  const SurfaceGrid grid = grid_of(ball(center, radius));
  Random random(1, 0);
  std::vector<RayHit> hits;
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 direction = random_direction(random);
    const glm::dvec3 through = center + 1.2 * radius * random_direction(random);
    const Ray ray{through - 2.0 * direction, direction};
    const double middle = glm::dot(center - ray.origin, direction);
    const glm::dvec3 off = ray.at(middle) - center;
    const double square = radius * radius - glm::dot(off, off);
    all_hits(grid, ray, hits);
    const auto first = first_hit(grid, ray);
    EXPECT_EQ(hits_anything(grid, ray, 0.0, 4.0), square > 0.0);
    if (square < 0.0) {
      EXPECT_TRUE(hits.empty());
      EXPECT_FALSE(first);
      continue;
    }
    ASSERT_EQ(hits.size(), 2u);
    ASSERT_TRUE(first);
    EXPECT_EQ(first->t, hits[0].t);
    EXPECT_NEAR(hits[0].t, middle - std::sqrt(square), 1e-6);
    EXPECT_NEAR(hits[1].t, middle + std::sqrt(square), 1e-6);
    EXPECT_TRUE(hits[0].enters);
    EXPECT_FALSE(hits[1].enters);
    EXPECT_LT(glm::length(hits[1].normal - unit(hits[1].position - center)), 1e-9);
  }
}

TEST(RayCast, rays_through_an_ellipsoid_agree_with_the_formula) {
  const glm::dvec3 a = unit({1, 2, -0.5}), b = unit(glm::cross(a, glm::dvec3(0.3, -1, 0.8)));
  const Ellipsoid ellipsoid{{0.1, 0.9, 0.2}, {a, b, glm::cross(a, b)}, {0.3, 0.12, 0.06}};
  const SurfaceGrid grid = grid_of({{ellipsoid}, {{0, 0, 0.0}}});
  Random random(2, 0);
  std::vector<RayHit> hits;
  int hitting = 0;
  for (int i = 0; i < 2000; ++i) {
    const Ray ray{ellipsoid.center + random_direction(random), random_direction(random)};
    const Ray aimed{ray.origin, unit(ellipsoid.center + 0.15 * ray.direction - ray.origin)};
    // In the coordinates in which the ellipsoid is the unit ball.
    const glm::dvec3 o = ((aimed.origin - ellipsoid.center) * ellipsoid.axes) / ellipsoid.radii;
    const glm::dvec3 d = (aimed.direction * ellipsoid.axes) / ellipsoid.radii;
    const double dd = glm::dot(d, d), od = glm::dot(o, d), oo = glm::dot(o, o);
    const double square = od * od - dd * (oo - 1.0);
    all_hits(grid, aimed, hits);
    ASSERT_EQ(hits.size(), square > 0.0 ? 2u : 0u);
    if (hits.empty()) continue;
    ++hitting;
    EXPECT_NEAR(hits[0].t, (-od - std::sqrt(square)) / dd, 1e-6);
    EXPECT_NEAR(hits[1].t, (-od + std::sqrt(square)) / dd, 1e-6);
  }
  EXPECT_GT(hitting, 500);
}

TEST(RayCast, all_hits_on_a_posed_body_agree_with_the_full_distance_field) {
  const Body body = pose_body(walk(0.9));
  const SurfaceGrid grid = grid_of(body.surface);
  Random random(3, 0);
  std::vector<RayHit> hits;
  std::size_t most = 0;
  for (int i = 0; i < 60; ++i) {
    const glm::dvec3 to = random_point(random, {-0.35, 0.0, -0.1}, {0.35, 1.7, 0.1});
    const Ray ray{to - 2.5 * random_direction(random), {}};
    const Ray aimed{ray.origin, unit(to - ray.origin)};
    all_hits(grid, aimed, hits);
    expect_true(body.surface, aimed, hits, 5.0, 4e-4);
    EXPECT_EQ(hits.size() % 2, 0u);
    most = std::max(most, hits.size());
    const auto first = first_hit(grid, aimed);
    ASSERT_EQ(first.has_value(), !hits.empty());
    if (first) {
      EXPECT_EQ(first->t, hits[0].t);
    }
  }
  EXPECT_GE(most, 4u);
}

TEST(RayCast, rays_along_axes_and_cell_faces_find_the_same_as_others) {
  const Body body = pose_body(walk(0.2));
  const SurfaceGrid grid = grid_of(body.surface);
  Random random(4, 0);
  std::vector<RayHit> hits;
  for (int i = 0; i < 36; ++i) {
    glm::dvec3 origin = random_point(random, {-0.2, 0.1, -0.08}, {0.2, 1.7, 0.08});
    // Some rays run exactly along the faces and edges of cells.
    if (i % 3 > 0) origin.x = grid.origin().x + SurfaceGrid::kCell * grid.cell_at(origin).x;
    if (i % 3 > 1) origin.y = grid.origin().y + SurfaceGrid::kCell * grid.cell_at(origin).y;
    glm::dvec3 direction(0.0);
    direction[i % 3 == 0 ? i / 3 % 3 : 2] = i % 2 == 0 ? 1.0 : -1.0;
    const Ray ray{origin - 3.0 * direction, direction};
    all_hits(grid, ray, hits);
    expect_true(body.surface, ray, hits, 6.0, 4e-4);
    const Ray askew{ray.origin, unit(direction + glm::dvec3(1e-11, -2e-11, 3e-11))};
    const auto first = first_hit(grid, ray), other = first_hit(grid, askew);
    ASSERT_EQ(first.has_value(), other.has_value());
    if (first) {
      EXPECT_NEAR(first->t, other->t, 1e-6);
    }
  }
}

TEST(RayCast, grazing_rays_are_exact_on_both_sides_of_the_tangent) {
  const double radius = 0.05;
  const SurfaceGrid grid = grid_of(ball({0, 0, 0}, radius));
  std::vector<RayHit> hits;
  for (const double depth : {1e-3, 1e-5, 1e-7, 3e-9}) {
    for (int turn = 0; turn < 50; ++turn) {
      Random random(5, static_cast<std::uint64_t>(turn));
      const glm::dvec3 normal = random_direction(random);
      const glm::dvec3 along = unit(glm::cross(normal, random_direction(random)));
      const Ray inner{normal * (radius - depth) - along, along};
      all_hits(grid, inner, hits);
      ASSERT_EQ(hits.size(), 2u) << depth;
      const double half = std::sqrt(radius * radius - (radius - depth) * (radius - depth));
      EXPECT_NEAR(hits[0].t, 1.0 - half, 2e-6) << depth;
      EXPECT_NEAR(hits[1].t, 1.0 + half, 2e-6) << depth;
      const Ray outer{normal * (radius + depth) - along, along};
      all_hits(grid, outer, hits);
      EXPECT_TRUE(hits.empty()) << depth;
    }
  }
}

TEST(RayCast, passes_fillets_creases_and_narrow_gaps_exactly) {
  // A gap of a tenth of a millimetre, a sharp crease, and a fillet.
  const Surface surface{{RoundCone{{0, 0, 0}, {0, 0, 0}, 0.05, 0.05},
                         RoundCone{{0.1001, 0, 0}, {0.1001, 0, 0}, 0.05, 0.05},
                         RoundCone{{0, 0.08, 0}, {0, 0.08, 0}, 0.05, 0.05},
                         RoundCone{{0.1001, 0.08, 0}, {0.1001, 0.08, 0}, 0.05, 0.05}},
                        {{0, 0, 0.0}, {1, 3, 0.03}, {2, 2, 0.0}}};
  const SurfaceGrid grid = grid_of(surface);
  std::vector<RayHit> hits;
  all_hits(grid, {{-1, 0, 0}, {1, 0, 0}}, hits);
  ASSERT_EQ(hits.size(), 4u);
  EXPECT_NEAR(hits[1].t, 1.05, 1e-6);
  EXPECT_NEAR(hits[2].t, 1.0501, 1e-6);
  Random random(6, 0);
  for (int i = 0; i < 150; ++i) {
    const bool crease = i % 2 == 0;
    const glm::dvec3 to =
        glm::dvec3(crease ? 0.0 : 0.1001, 0.04, 0.0) + 0.04 * random_direction(random);
    const glm::dvec3 direction = random_direction(random);
    const Ray ray{to - 0.5 * direction, direction};
    all_hits(grid, ray, hits);
    expect_true(surface, ray, hits, 1.0, 1e-5);
  }
}

TEST(RayCast, a_ray_that_begins_inside_leaves_before_it_enters) {
  const Body body = pose_body(walk(0.0));
  const SurfaceGrid grid = grid_of(body.surface);
  Random random(7, 0);
  std::vector<RayHit> hits;
  int inside = 0;
  for (int i = 0; i < 100; ++i) {
    const Ray ray{random_point(random, {-0.12, 0.95, -0.08}, {0.12, 1.4, 0.08}),
                  random_direction(random)};
    if (value_at(body.surface, ray.origin) > 0.0) continue;
    ++inside;
    all_hits(grid, ray, hits);
    ASSERT_EQ(hits.size() % 2, 1u);
    EXPECT_FALSE(hits[0].enters);
    EXPECT_GE(glm::dot(hits[0].normal, ray.direction), -1e-3);
    expect_true(body.surface, ray, hits, 3.0, 1e-3);
  }
  EXPECT_GT(inside, 50);
}

TEST(RayCast, only_hits_between_the_ends_of_a_ray_count) {
  const SurfaceGrid grid = grid_of(ball({0, 0, 0}, 0.5));
  const Ray ray{{-2, 0.1, 0.05}, {1, 0, 0}};
  const double half = std::sqrt(0.25 - 0.0125);
  EXPECT_FALSE(first_hit(grid, ray, 0.0, 2.0 - half - 1e-6));
  EXPECT_TRUE(first_hit(grid, ray, 0.0, 2.0 - half + 1e-6)->enters);
  EXPECT_NEAR(first_hit(grid, ray, 2.0)->t, 2.0 + half, 1e-9);
  EXPECT_FALSE(hits_anything(grid, ray, 2.0 + half + 1e-6, 100.0));
  EXPECT_FALSE(first_hit(grid, ray, 3.0, 1.0));
}

TEST(RayCast, hit_near_finds_what_first_hit_finds_from_a_place_nearby) {
  const SurfaceGrid grid = grid_of(pose_body(walk(0.4)).surface);
  Random random(5, 0);
  std::size_t hits = 0, found = 0;
  while (hits < 2000) {
    const glm::dvec3 from = glm::dvec3(0, 0.9, 0) + 2.0 * random_direction(random);
    const glm::dvec3 to = random_point(random, {-0.3, 0.0, -0.3}, {0.3, 1.8, 0.3});
    const glm::dvec3 way = 0.8 * unit(to - from);
    const auto hit = first_hit(grid, {from, unit(way)});
    if (!hit || glm::dot(hit->normal, unit(way)) > -0.5) continue;
    ++hits;
    const double depth = hit->t / 0.8;
    const auto near = hit_near(grid, from, way, depth + 0.003 * (2.0 * random.uniform() - 1.0));
    if (!near || std::abs(near->depth - depth) > 0.005) continue;  // it may find another passage
    ++found;
    EXPECT_NEAR(near->depth, depth, 1e-6);
    EXPECT_LT(glm::distance(near->position, hit->position), 1e-6);
    EXPECT_GT(glm::dot(unit(near->gradient), hit->normal), 0.999);
  }
  EXPECT_GT(found, hits * 97 / 100);
  EXPECT_FALSE(hit_near(grid, {0, 0.9, 5}, {0, 0, -1}, 1.0)) << "there is nothing";
}

}  // namespace
}  // namespace pointreel::ray_cast_test
