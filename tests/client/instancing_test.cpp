#include <random>

#include "client/render/opengl/gl_renderer.h"
#include "tests/client/renderer_test.h"

namespace pointreel::instancing_test {
namespace {

/// Some surfels face away and some have unknown orientation. There are more than a batch of uniform
/// buffers can hold.
PointCloud prickly_sphere(int points, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  PointCloud cloud;
  for (int i = 0; i < points; ++i) {
    const glm::vec3 n = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    const glm::vec3 towards =
        glm::normalize(n + 0.5f * glm::vec3(normal(random), normal(random), normal(random)));
    add(cloud, n, i % 17 == 0 ? glm::vec3(0.0f) : towards,
        glm::u16vec3(random(), random(), random()), 0.04f);
  }
  return cloud;
}

/// Share of the pixels that differ by more than rounding.
double share_different(const Image& a, const Image& b, int but_for = 2) {
  std::size_t different = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    different += difference(a.pixels[i], b.pixels[i]) > but_for ? 1u : 0u;
  return static_cast<double>(different) / static_cast<double>(a.pixels.size());
}

class InstancingTest : public RendererTest {};
INSTANTIATE_TEST_SUITE_P(, InstancingTest, testing::Values(RendererChoice::opengl), renderer_name);

TEST_P(InstancingTest, every_method_of_instancing_draws_the_same_surfels) {
  const auto frame = frame_of(prickly_sphere(5000, 3));
  auto estimated = frame_of(prickly_sphere(3000, 4));
  estimated->normals_estimated = true;
  Camera close = front_camera();
  close.distance = 0.9;  // inside the sphere: surfels behind the eye and across the near plane
  Camera far = front_camera();
  far.distance = 9.0;
  for (const Splatting splatting :
       {Splatting::normalized, Splatting::two_pass, Splatting::no_depth}) {
    for (const Camera& camera : {front_camera(), close, far}) {
      DrawOptions options = plain(DrawMode::surfel);
      options.lighting = true;
      options.splatting = splatting;
      options.instancing = Instancing::attribute;
      const Image one = picture(frame, camera, options);
      const Image two = picture(estimated, camera, options);
      EXPECT_LT(count_near(one, kBackground, 0), one.pixels.size() * 24 / 25);
      EXPECT_GT(share_different(one, two), 0.04);
      for (const Instancing other :
           {Instancing::geometry, Instancing::uniform, Instancing::texture}) {
        options.instancing = other;
        EXPECT_LT(share_different(one, picture(frame, camera, options)), 0.001) << name(other);
        EXPECT_LT(share_different(two, picture(estimated, camera, options)), 0.001) << name(other);
      }
    }
  }
}

/// Its colour changes slowly, so that pixels at the rims of single surfels do not matter.
PointCloud smooth_sphere(int points) {
  PointCloud cloud = prickly_sphere(points, 8);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3 p = cloud.positions[i];
    if (cloud.normals[i] != glm::vec3(0.0f))
      cloud.normals[i] = glm::normalize(cloud.normals[i] + 3.0f * p);
    cloud.colors[i] = glm::u16vec3(32767.0f * (1.0f + p));
  }
  return cloud;
}

TEST_P(InstancingTest, pulled_points_look_like_quads) {
  const auto frame = frame_of(smooth_sphere(20000));
  auto estimated = frame_of(smooth_sphere(20000));
  estimated->normals_estimated = true;
  // From points alone to quads alone, and mixtures of both.
  for (const double distance : {12.0, 6.0, 3.0, 1.5, 1.05, 0.5}) {
    Camera camera = front_camera();
    camera.distance = distance;
    for (const auto& drawn : {frame, estimated}) {
      DrawOptions options = plain(DrawMode::surfel);
      options.lighting = true;
      options.instancing = Instancing::attribute;
      const Image quads = picture(drawn, camera, options);
      EXPECT_LT(count_near(quads, kBackground, 0), quads.pixels.size() * 39 / 40);
      options.instancing = Instancing::pull;
      EXPECT_LT(share_different(quads, picture(drawn, camera, options), 8), 0.005) << distance;
    }
  }
}

TEST_P(InstancingTest, every_method_of_instancing_draws_the_same_voxels) {
  const auto frame = frame_of(prickly_sphere(5000, 5), 6);
  for (const VoxelShape shape : {VoxelShape::faces, VoxelShape::cube}) {
    DrawOptions options = plain(DrawMode::voxel);
    options.lighting = true;
    options.voxel_shape = VoxelShape::faces;
    options.instancing = Instancing::attribute;
    const Image one = picture(frame, front_camera(), options);
    options.voxel_shape = shape;
    for (const Instancing other : {Instancing::geometry, Instancing::uniform, Instancing::texture,
                                   Instancing::attribute, Instancing::pull}) {
      options.instancing = other;
      EXPECT_LT(share_different(one, picture(frame, front_camera(), options)), 0.001)
          << name(other);
    }
  }
}

TEST_P(InstancingTest, skips_voxels_that_others_hide_without_changing_the_picture) {
  PointCloud cloud;
  std::mt19937 random(6);
  for (int i = 0; i < 20 * 20 * 20; ++i) {
    const glm::ivec3 cell(i % 20, i / 20 % 20, i / 400);
    if (random() % 8 == 0) continue;
    add(cloud, glm::vec3(cell - 10) * (3.0f / 32) + 0.05f, glm::vec3(0.0f),
        glm::u16vec3(random(), random(), random()), 0.1f);
  }
  const auto all = frame_of(cloud, 5);
  auto some = frame_of(cloud, 5);
  some->neighbors = leaf_neighbors(some->svo);
  for (int corner = 0; corner < 8; ++corner) {
    Camera camera = front_camera();
    camera.orbit(0.785 + 1.5708 * (corner & 3), corner & 4 ? 0.6 : -0.6);
    const Image one = picture(all, camera, plain(DrawMode::voxel));
    const std::uint32_t drawn = stats_.drawn;
    EXPECT_EQ(stats_.hidden, 0u);
    const Image two = picture(some, camera, plain(DrawMode::voxel));
    EXPECT_EQ(largest_difference(one, two), 0);
    EXPECT_LT(stats_.drawn, drawn / 2);
    EXPECT_EQ(stats_.drawn + stats_.hidden, drawn);
  }
  // The surfels of the same tree are all drawn.
  some->cloud = {};
  picture(some, front_camera(), plain(DrawMode::surfel));
  EXPECT_EQ(stats_.hidden, 0u);
}

}  // namespace
}  // namespace pointreel::instancing_test
