#include <cmath>
#include <memory>
#include <numbers>

#include <gtest/gtest.h>

#include "client/render/light_probe.h"
#include "client/render/software/software_renderer.h"
#include "client/render/srgb.h"
#include "common/base/tbb_executor.h"
#include "tests/unit/renderer_test.h"

namespace pointreel {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kAlbedo = 0.63076;  ///< of 0xd0d0 in sRGB

double luminance(const glm::dvec3& c) { return glm::dot(c, glm::dvec3(0.2126, 0.7152, 0.0722)); }

/// The reflectance of the sphere: diffuse, and GGX with the shadowing of Smith.
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

glm::dvec3 integral(const EnvironmentMap& map, const glm::dvec3& n, const glm::dvec3& to_eye,
                    double roughness) {
  glm::dvec3 sum(0.0);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const glm::dvec3 d(direction_of_texel(map, x, y));
      const double lit = glm::dot(n, d);
      if (lit > 0.0)
        sum += lit * static_cast<double>(solid_angle_of_texel(map, y)) *
               reflectance(n, to_eye, d, roughness) * glm::dvec3(map.at(x, y));
    }
  return sum;
}

class LateLight : public testing::TestWithParam<float> {};

/// A sphere takes no light from itself, so the light of each pixel is an integral over the
/// environment.
TEST_P(LateLight, of_a_dense_sphere_is_near_the_integral_over_its_environment) {
  const double roughness = static_cast<double>(GetParam());
  PointCloud cloud;
  constexpr int kPoints = 40'000;
  for (int i = 0; i < kPoints; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / kPoints, r = std::sqrt(1.0 - z * z),
                 a = 2.39996323 * i;
    const glm::vec3 n(glm::dvec3(r * std::cos(a), z, r * std::sin(a)));
    add(cloud, n, n, kRed, 2.2f / std::sqrt(static_cast<float>(kPoints)));
  }
  auto environment = std::make_shared<EnvironmentMap>(studio_environment());
  DrawOptions options = plain(DrawMode::surfel);
  options.color = ColorSource::plain;
  options.light = Light::environment;
  options.environment = environment;
  options.roughness = GetParam();
  const Camera camera = front_camera();
  SoftwareRenderer renderer(tbb_executor());
  ASSERT_TRUE(renderer.draw(frame_of(std::move(cloud), 8), camera, kSize, options));
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
      const double along = glm::dot(eye, ray), inside = along * along - glm::dot(eye, eye) + 1.0;
      if (inside < 0.02) continue;  // beside the sphere, or at its rim
      const glm::dvec3 n = eye + (-along - std::sqrt(inside)) * ray;
      const glm::dvec3 light = scale * integral(*environment, n, -ray, roughness);
      for (int i = 0; i < 3; ++i) {
        const double expected = 255.0 * srgb_from_linear(toned(light[i]));
        squares += std::pow(expected - image.at(x, y)[i], 2.0);
        ++count;
      }
    }
  ASSERT_GT(count, 3000);
  const double psnr = 10.0 * std::log10(255.0 * 255.0 * count / squares);
  RecordProperty("psnr", std::to_string(psnr));
  EXPECT_GT(psnr, 25.0);
}

INSTANTIATE_TEST_SUITE_P(Roughness, LateLight, testing::Values(0.3f, 0.5f, 0.9f));

}  // namespace
}  // namespace pointreel
