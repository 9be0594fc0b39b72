#include "tests/bench/render/truth.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include <gtest/gtest.h>

#include "client/render/opengl/gl_context.h"
#include "client/render/opengl/gl_renderer.h"
#include "tests/bench/render/scenes.h"
#include "tests/bench/render/viewpoints.h"

namespace pointreel::bench::truth_test {
namespace {

constexpr glm::ivec2 kSize(180, 120);

/// A skin-coloured ball with a small ball of hair in front of its centre.
TruthScene balls() {
  Body body;
  const glm::dvec3 center(0.1, 0.9, -0.2), small(0.1, 0.9, 0.3);
  body.surface = {{RoundCone{center, center, 0.2, 0.2}, RoundCone{small, small, 0.04, 0.04}},
                  {{0, 0, 0.0}, {1, 1, 0.0}}};
  body.parts = {{Bone::pelvis, Material::skin}, {Bone::pelvis, Material::hair}};
  return make_truth_scene(std::move(body)).value();
}

Camera camera_at(double distance, double yaw, double pitch) {
  Camera camera;
  camera.target = {0.07, 0.92, -0.15};
  camera.distance = distance;
  camera.yaw = yaw;
  camera.pitch = pitch;
  return camera;
}

TEST(Truth, misses_no_ray_that_meets_the_surface) {
  const TruthScene scene = balls();
  for (const double distance : {1.2, 0.5, 0.33, 0.1}) {  // the last distance is inside the ball
    const Camera camera = camera_at(distance, 0.4, -0.3);
    const TruthPicture picture = cast_truth(scene, camera, kSize, {});
    const double half = std::tan(0.5 * camera.fov_y);
    std::size_t covered = 0;
    for (int y = 0; y < kSize.y; ++y) {
      for (int x = 0; x < kSize.x; ++x) {
        const double right = half * 1.5 * ((x + 0.5) / 90.0 - 1.0),
                     up = half * (1 - (y + 0.5) / 60);
        const Ray ray{camera.eye(), glm::normalize(camera.axes() * glm::dvec3(right, up, -1.0))};
        const bool meets = first_hit(scene.grid, ray).has_value();
        covered += meets;
        ASSERT_EQ(picture.mask[static_cast<std::size_t>(y * kSize.x + x)] != 0, meets)
            << distance << ": " << x << ", " << y;
      }
    }
    EXPECT_GT(covered, 1000u);
    EXPECT_NEAR(truth_coverage(scene, camera, kSize),
                static_cast<double>(covered) / (kSize.x * kSize.y), 1e-12);
  }
}

Image moved(const Image& image, const glm::ivec2& by) {
  Image result = image;
  for (int y = 1; y + 1 < image.height; ++y) {
    for (int x = 1; x + 1 < image.width; ++x) {
      result.pixels[static_cast<std::size_t>(y * image.width + x)] = image.at(x - by.x, y - by.y);
    }
  }
  return result;
}

/// Lit or unlit, textured or not, the renderer must draw points of the surface as the same picture
/// at the same place.
TEST(Truth, agrees_with_the_picture_of_very_many_points) {
  const auto context = OffscreenContext::create();
  ASSERT_TRUE(context) << context.error().message;
  auto renderer = GlRenderer::create();
  ASSERT_TRUE(renderer) << renderer.error().message;
  const TruthScene scene = balls();
  const double area = surface_area(scene.grid).value();
  EXPECT_NEAR(area, 4.0 * std::numbers::pi * (0.04 + 0.0016), 0.005);
  PointCloud cloud = even_cloud(scene.body, area, 8'000).value();
  cloud.radii.assign(cloud.size(), static_cast<float>(0.7 * std::sqrt(area / 8'000)));
  for (const bool texture : {true, false}) {
    if (!texture) cloud.colors.clear();
    const auto frame = prepare_cloud(cloud, DrawMode::surfel, 0.7).value();
    for (const bool lighting : {true, false}) {
      DrawOptions options;
      options.color = texture ? ColorSource::colors : ColorSource::normals;
      options.lighting = lighting;
      options.fill_holes = false;  // filling would widen outlines
      options.background = {0.2f, 0.6f, 0.4f};
      const Camera camera = camera_at(0.9, 0.7, 0.4);
      ASSERT_TRUE(renderer->draw(frame, camera, kSize, options));
      const Image drawn = renderer->read_pixels().value();
      const TruthPicture truth =
          cast_truth(scene, camera, kSize, {texture, lighting, options.background});
      // Away from the edges, where coverage may differ by a pixel.
      Mask inner(truth.mask.size(), 0);
      for (int y = 2; y + 2 < kSize.y; ++y) {
        for (int x = 2; x + 2 < kSize.x; ++x) {
          bool all = true;
          for (int v = y - 2; v <= y + 2; ++v) {
            for (int u = x - 2; u <= x + 2; ++u) {
              all = all && truth.mask[static_cast<std::size_t>(v * kSize.x + u)] != 0;
            }
          }
          inner[static_cast<std::size_t>(y * kSize.x + x)] = all;
        }
      }
      EXPECT_GT(*psnr(truth.image, drawn, inner), texture ? 34.0 : 40.0) << texture << lighting;
      EXPECT_GT(*psnr(truth.image, drawn), 28.0);
      // Moving the picture by a pixel makes it equally wrong in both directions. With an offset of
      // half a pixel, one direction would be better by 10 dB.
      for (const glm::ivec2 step : {glm::ivec2(1, 0), glm::ivec2(0, 1)}) {
        EXPECT_NEAR(*psnr(truth.image, moved(drawn, step)), *psnr(truth.image, moved(drawn, -step)),
                    1.0);
      }
    }
  }
}

TEST(Truth, distinguishes_hidden_points) {
  const TruthScene scene = balls();
  const glm::dvec3 eye(0.1, 0.9, 3.0);
  const std::vector<bool> hidden =
      hidden_points(scene, eye,
                    {{0.1, 0.9, 0.34},     // the front of the small ball
                     {0.1, 0.9, 0.338},    // noise just below its surface
                     {0.1, 0.9, 0.0},      // the front of the large ball, behind the small one
                     {0.22, 0.9, -0.041},  // beside the small ball
                     {0.1, 0.9, -0.4}},    // the back of the large ball
                    0.01);
  EXPECT_EQ(hidden, (std::vector<bool>{false, false, true, false, true}));
}

TEST(EvenCloud, keeps_points_apart_and_leaves_no_gap) {
  const TruthScene scene = balls();
  const double area = surface_area(scene.grid).value();
  const PointCloud cloud = even_cloud(scene.body, area, 2000).value();
  const double least = 0.75 * std::sqrt(area / 2000);
  EXPECT_GT(cloud.size(), 1700u);
  EXPECT_LT(cloud.size(), 2400u);
  const auto nearest = [&](const glm::vec3& p, std::size_t but) {
    float square = 1e9f;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const glm::vec3 d = cloud.positions[i] - p;
      if (i != but) square = std::min(square, glm::dot(d, d));
    }
    return std::sqrt(square);
  };
  for (std::size_t i = 0; i < cloud.size(); i += 7) {
    EXPECT_GE(nearest(cloud.positions[i], i), 0.999 * least);
    // Away from the small ball, every point has a close neighbour.
    const glm::vec3 center(0.1f, 0.9f, -0.2f);
    const glm::vec3 n = cloud.normals[i];
    if (glm::dot(cloud.positions[i] - center, n) < 0.15f) continue;  // part of the small ball
    const glm::vec3 aside = glm::normalize(glm::cross(n, glm::vec3(0.3f, 0.9f, 0.2f)));
    const glm::vec3 p = center + 0.2f * glm::normalize(n + 0.1f * aside);
    EXPECT_LT(nearest(p, cloud.size()), 1.3 * least);
  }
}

TEST(Viewpoints, cover_as_much_of_the_picture_as_they_state) {
  const TruthScene scene = make_truth_scene(pose_body(find_motion("kick")->pose(1.0))).value();
  const auto views = viewpoints(scene, {1920, 1280}, 2);
  ASSERT_EQ(views.size(), 2u);
  for (const Viewpoint& view : views) {
    EXPECT_NEAR(truth_coverage(scene, view.camera, kSize), view.coverage, 0.04) << view.name;
  }
}

}  // namespace
}  // namespace pointreel::bench::truth_test
