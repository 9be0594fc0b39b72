#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <span>

#include <gtest/gtest.h>

#include "client/render/light_probe.h"
#include "client/render/software/software_renderer.h"
#include "client/render/srgb.h"
#include "common/threads/tbb_executor.h"
#include "tests/client/renderer_test.h"

namespace pointreel::late_light_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kAlbedo = 0.63076;  ///< of 0xd0d0 in sRGB

double luminance(const glm::dvec3& c) { return glm::dot(c, glm::dvec3(0.2126, 0.7152, 0.0722)); }

/// The reflectance of balls: diffuse, and GGX with the shadowing of Smith.
double reflectance(const glm::dvec3& n, const glm::dvec3& to_eye, const glm::dvec3& to_light,
                   double roughness) {
  const double alpha2 = std::pow(roughness, 4.0), facing = glm::dot(n, to_eye),
               lit = glm::dot(n, to_light);
  const glm::dvec3 half = glm::normalize(to_eye + to_light);
  const double base = std::pow(glm::dot(n, half), 2.0) * (alpha2 - 1.0) + 1.0;
  const double spread = alpha2 / (kPi * base * base);
  const double fresnel = 0.04 + 0.96 * std::pow(1.0 - glm::dot(to_eye, half), 5.0);
  const auto part = [&](double a, double b) {
    return a * std::sqrt(alpha2 + (1.0 - alpha2) * b * b);
  };
  return kAlbedo / kPi + spread * fresnel * 0.5 / (part(lit, facing) + part(facing, lit));
}

double toned(double light) {
  return light <= 0.6 ? light : 0.6 + 0.4 * (light - 0.6) / (light - 0.2);
}

struct Ball {
  glm::dvec3 center;
  double radius;
};

/// How far a ray from a point goes until it meets a ball, along a unit vector.
std::optional<double> distance_to(const Ball& ball, const glm::dvec3& from, const glm::dvec3& ray) {
  const glm::dvec3 way = ball.center - from;
  const double along = glm::dot(way, ray),
               inside = along * along - glm::dot(way, way) + ball.radius * ball.radius;
  if (inside < 0.0 || along < std::sqrt(inside)) return std::nullopt;
  return along - std::sqrt(inside);
}

/// A point of a ball's surface.
struct Seen {
  std::size_t ball;
  glm::dvec3 place, normal;
};

std::optional<Seen> first_along(std::span<const Ball> balls, const glm::dvec3& from,
                                const glm::dvec3& ray) {
  std::optional<Seen> first;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < balls.size(); ++i)
    if (const auto far = distance_to(balls[i], from, ray); far && *far < nearest) {
      nearest = *far;
      const glm::dvec3 place = from + nearest * ray;
      first = {i, place, (place - balls[i].center) / balls[i].radius};
    }
  return first;
}

/// The light that comes from the environment and is reflected once.
glm::dvec3 traced(const EnvironmentMap& map, std::span<const Ball> balls, const Seen& seen,
                  const glm::dvec3& to_eye, double roughness) {
  glm::dvec3 sum(0.0);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const glm::dvec3 d(direction_of_texel(map, x, y));
      const double lit = glm::dot(seen.normal, d);
      if (lit <= 0.0) continue;
      bool blocked = false;
      for (std::size_t i = 0; i < balls.size() && !blocked; ++i)
        blocked = i != seen.ball && distance_to(balls[i], seen.place, d).has_value();
      if (!blocked)
        sum += lit * static_cast<double>(solid_angle_of_texel(map, y)) *
               reflectance(seen.normal, to_eye, d, roughness) * glm::dvec3(map.at(x, y));
    }
  return sum;
}

class LateLight : public testing::TestWithParam<float> {
 protected:
  /// The PSNR of balls of many surfels, as the software renderer lights them, against rays traced
  /// from every second pixel in each direction, except at outlines.
  double psnr_of(std::span<const Ball> balls) {
    const double roughness = static_cast<double>(GetParam());
    PointCloud cloud;
    for (const Ball& ball : balls) {
      const int points = static_cast<int>(40'000 * ball.radius * ball.radius);
      for (int i = 0; i < points; ++i) {
        const double z = 1.0 - 2.0 * (i + 0.5) / points, r = std::sqrt(1.0 - z * z),
                     a = 2.39996323 * i;
        const glm::dvec3 n(r * std::cos(a), z, r * std::sin(a));
        add(cloud, glm::vec3(ball.center + ball.radius * n), glm::vec3(n), kRed,
            static_cast<float>(2.2 * ball.radius / std::sqrt(points)));
      }
    }
    auto environment = std::make_shared<EnvironmentMap>(studio_environment());
    DrawOptions options = plain(DrawMode::surfel);
    options.color = ColorSource::plain;
    options.light = Light::environment;
    options.environment = environment;
    options.roughness = GetParam();
    const Camera camera = front_camera();
    SoftwareRenderer renderer(tbb_executor());
    if (!renderer.draw(frame_of(std::move(cloud), 8), camera, kSize, options)) return 0.0;
    const Image image = renderer.read_pixels().value();

    // Pictures are scaled so that a white diffuse surface that faces the key light is nearly white.
    const glm::dvec3 key(make_light_probe(*environment, GetParam()).key_direction);
    glm::dvec3 brightest(0.0);
    for (int y = 0; y < environment->height; ++y)
      for (int x = 0; x < environment->width; ++x)
        brightest +=
            std::max(glm::dot(key, glm::dvec3(direction_of_texel(*environment, x, y))), 0.0) *
            static_cast<double>(solid_angle_of_texel(*environment, y)) / kPi *
            glm::dvec3(environment->at(x, y));
    const double scale = 0.9 / luminance(brightest);

    const glm::dvec3 eye = camera.eye();
    const double step = 2.0 * std::tan(0.5 * camera.fov_y) / kSize.y;
    double squares = 0.0;
    int count = 0;
    for (int y = 0; y < image.height; y += 2)
      for (int x = 0; x < image.width; x += 2) {
        const glm::dvec3 ray = glm::normalize(
            glm::dvec3(step * (x + 0.5 - 0.5 * kSize.x), step * (0.5 * kSize.y - y - 0.5), -1.0));
        const auto seen = first_along(balls, eye, ray);
        if (!seen || glm::dot(seen->normal, -ray) < 0.14) continue;
        const glm::dvec3 light = scale * traced(*environment, balls, *seen, -ray, roughness);
        for (int i = 0; i < 3; ++i) {
          const double expected = 255.0 * srgb_from_linear(toned(light[i]));
          squares += std::pow(expected - image.at(x, y)[i], 2.0);
          ++count;
        }
      }
    EXPECT_GT(count, 3000);
    const double psnr = 10.0 * std::log10(255.0 * 255.0 * count / squares);
    RecordProperty("psnr", std::to_string(psnr));
    return psnr;
  }
};

TEST_P(LateLight, of_a_ball_is_near_that_of_rays) {
  EXPECT_GT(psnr_of(std::array{Ball{{0.0, 0.0, 0.0}, 1.0}}), 25.0);
}

/// With shadows, and with surfaces that take light from each other.
TEST_P(LateLight, of_balls_that_touch_is_near_that_of_rays) {
  const Ball large{{-0.25, -0.3, -0.2}, 0.65}, high{{0.3, 0.42, 0.2}, 0.35},
      right{{0.62, -0.35, 0.25}, 0.35};
  EXPECT_GT(psnr_of(std::array{large, high, right}), 25.0);
}

INSTANTIATE_TEST_SUITE_P(Roughness, LateLight, testing::Values(0.3f, 0.5f, 0.9f));

}  // namespace
}  // namespace pointreel::late_light_test
