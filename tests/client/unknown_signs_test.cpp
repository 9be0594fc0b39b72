// Surfels whose normals were estimated, so that their signs may be wrong.

#include <cmath>
#include <random>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "client/prepare/prepare.h"
#include "codec/core/normal_lines.h"
#include "tests/client/renderer_test.h"

namespace pointreel::unknown_signs_test {
namespace {

constexpr glm::u8vec3 kNear(0, 0, 255), kFar(255, 0, 0);

/// Random points on a sphere of radius 1, blue on the side of the eye and red on the other. With
/// `noise`, they are off the sphere by about this much.
PointCloud sparse_sphere(int points, unsigned seed, float noise) {
  std::mt19937 random(seed);
  std::normal_distribution<float> gauss;
  PointCloud cloud;
  for (int i = 0; i < points; ++i) {
    const glm::vec3 n = glm::normalize(glm::vec3(gauss(random), gauss(random), gauss(random)));
    cloud.positions.push_back(n * (1.0f + noise * gauss(random)));
    cloud.colors.push_back(n.z > 0.0f ? kBlue : kRed);
  }
  return cloud;
}

/// The frame of a file of this cloud's points and colours.
std::shared_ptr<SceneFrame> frame_of_file(const PointCloud& cloud, const PrepareOptions& options) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty "
      "float z\nproperty ushort red\nproperty ushort green\nproperty ushort blue\nend_header\n",
      cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3 p = cloud.positions[i];
    const glm::u16vec3 c = cloud.colors[i];
    text += fmt::format("{} {} {} {} {} {}\n", p.x, p.y, p.z, c.x, c.y, c.z);
  }
  FetchedFrame file;
  file.file = Bytes(text.begin(), text.end());
  auto scene = prepare_frame(file, {}, options);
  EXPECT_TRUE(scene) << scene.error().message;
  return std::make_shared<SceneFrame>(scene ? *std::move(scene) : SceneFrame{});
}

/// How many pixels within this share of the sphere's outline satisfy the condition.
template <class Condition>
int count_inside(const Image& image, const Camera& camera, double share, Condition condition) {
  const double distance = camera.distance, sine = 1.0 / distance;
  const double outline =
      0.5 * image.height * sine / std::sqrt(1.0 - sine * sine) / std::tan(0.5 * camera.fov_y);
  int count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const glm::dvec2 from_middle(x + 0.5 - 0.5 * image.width, y + 0.5 - 0.5 * image.height);
      if (glm::length(from_middle) < share * outline && condition(image.at(x, y))) ++count;
    }
  }
  return count;
}

class UnknownSigns : public RendererTest {};

INSTANTIATE_TEST_SUITE_P(, UnknownSigns, kBothRenderers, renderer_name);

TEST_P(UnknownSigns, the_far_side_of_a_sparse_sphere_does_not_show_through_its_near_side) {
  const auto reddish = [](const glm::u8vec3& p) { return p.r > p.b; };
  int red_without = 0;
  for (const int points : {1000, 4000, 20000}) {
    for (const float noise : {0.0f, 0.01f}) {
      const auto frame = frame_of_file(sparse_sphere(points, 5, noise), {});
      ASSERT_TRUE(frame->normals_estimated);
      for (const double distance : {2.2, 4.0, 12.0}) {
        for (const Instancing instancing : {Instancing::pull, Instancing::attribute}) {
          Camera camera = front_camera();
          camera.distance = distance;
          DrawOptions options = plain(DrawMode::surfel);
          options.instancing = instancing;
          const glm::ivec2 size(480, 360);
          const Image image = picture(frame, camera, options, size);
          EXPECT_EQ(count_inside(image, camera, 0.85, reddish), 0)
              << points << ", " << noise << ", " << distance;
          EXPECT_GT(count_inside(image, camera, 0.85, [](auto& p) { return p == kNear; }), 100);
          options.fill_holes = false;
          red_without += count_inside(picture(frame, camera, options, size), camera, 0.85, reddish);
        }
      }
    }
  }
  EXPECT_GT(red_without, 200) << "there are holes that must be filled";
}

TEST_P(UnknownSigns, voxels_close_a_sparse_sphere_from_all_sides) {
  const auto shows_through = [](const glm::u8vec3& p) { return p == kFar || p == kBackground; };
  const glm::ivec2 size(480, 360);
  DrawOptions filled = plain(DrawMode::voxel), open = filled;
  open.fill_holes = false;
  PrepareOptions prepare;
  prepare.mode = DrawMode::voxel;
  int all = 0, through = 0, through_open = 0;
  for (const int points : {1000, 4000, 20000}) {
    for (const float noise : {0.0f, 0.01f}) {
      PointCloud cloud = sparse_sphere(points, 5, noise);
      for (const auto& [yaw, pitch] :
           {std::pair{0.0, 0.0}, {0.5, 0.2}, {0.8, 0.6}, {2.0, -0.3}, {3.5, 1.4}}) {
        Camera camera = front_camera();
        camera.yaw = yaw;
        camera.pitch = pitch;
        for (std::size_t i = 0; i < cloud.size(); ++i) {
          const double facing = glm::dot(glm::dvec3(cloud.positions[i]), camera.eye());
          cloud.colors[i] = facing > 0.0 ? kBlue : kRed;
        }
        const auto frame = frame_of_file(cloud, prepare);
        const auto count = [&](const DrawOptions& options, const auto& condition) {
          return count_inside(picture(frame, camera, options, size), camera, 0.85, condition);
        };
        all += count(filled, [](const glm::u8vec3&) { return true; });
        through += count(filled, shows_through);
        through_open += count(open, shows_through);
      }
    }
  }
  // Hardly any gap is wider than those that are filled.
  EXPECT_LE(through, all / 5000) << "of " << all;
  EXPECT_GT(through_open, all / 50) << "there are holes that must be filled";
}

TEST_P(UnknownSigns, openings_and_depressions_wider_than_holes_stay_as_they_are) {
  // A red wall, and in front of it a blue one with a round opening, fourteen spacings wide.
  PointCloud cloud;
  for (int y = -40; y <= 40; ++y) {
    for (int x = -40; x <= 40; ++x) {
      const glm::vec2 at(0.025f * static_cast<float>(x), 0.025f * static_cast<float>(y));
      add(cloud, {at, -1.0f}, kFront, kRed, 0.025f);
      if (glm::length(at) > 0.175f) add(cloud, {at, 0.0f}, kFront, kBlue, 0.025f);
    }
  }
  const auto frame = frame_of(cloud);
  frame->normals_estimated = true;
  DrawOptions options = plain(DrawMode::surfel);
  const Image with = picture(frame, front_camera(), options);
  options.fill_holes = false;
  EXPECT_EQ(largest_difference(with, picture(frame, front_camera(), options)), 0);
  EXPECT_EQ(with.at(kSize.x / 2, kSize.y / 2), kFar);
}

TEST_P(UnknownSigns, do_not_change_a_picture_of_a_cloud) {
  const PointCloud cloud = [] {
    PointCloud all = sparse_sphere(3000, 2, 0.02f);
    std::mt19937 random(8);
    std::normal_distribution<float> gauss;
    for (const glm::vec3& p : all.positions) {
      all.normals.push_back(
          glm::normalize(p + 0.5f * glm::vec3(gauss(random), gauss(random), gauss(random))));
      all.radii.push_back(0.06f);
    }
    return all;
  }();
  for (const DrawMode mode : kModes) {
    for (int splatting = 0; splatting < static_cast<int>(kEnumNames<Splatting>.size());
         ++splatting) {
      if (mode != DrawMode::surfel && splatting > 0) continue;
      for (const Instancing instancing : {Instancing::pull, Instancing::attribute}) {
        DrawOptions options = plain(mode);
        options.lighting = true;
        options.splatting = static_cast<Splatting>(splatting);
        options.instancing = instancing;
        Image first;
        for (unsigned seed = 0; seed < 3; ++seed) {
          PointCloud turned = cloud;
          std::mt19937 random(seed);
          for (glm::vec3& n : turned.normals)
            if (seed > 0 && random() % 2 == 0) n = -n;
          // Voxels have the means of their points.
          auto frame = frame_of(turned);
          const SortedPoints sorted = sort_points(turned, frame->svo.cube);
          frame->attributes.normals = mean_normal_lines(frame->svo, turned, sorted);
          frame->normals_estimated = true;
          const Image image = picture(frame, front_camera(), options);
          if (seed == 0) first = image;
          EXPECT_EQ(largest_difference(first, image), 0)
              << name(mode) << ", " << name(options.splatting) << ", " << seed;
        }
      }
    }
  }
}

TEST_P(UnknownSigns, do_not_change_a_picture_of_a_coarse_tree) {
  PrepareOptions prepare;
  auto frame = frame_of_file(sparse_sphere(20000, 3, 0.0f), prepare);
  PointCloud cloud = frame->cloud;
  ASSERT_TRUE(cloud.has_normals());
  Image first;
  for (unsigned seed = 0; seed < 4; ++seed) {
    std::mt19937 random(seed);
    for (glm::vec3& n : cloud.normals)
      if (seed > 0 && random() % 2 == 0) n = -n;
    const SortedPoints sorted = sort_points(cloud, {cloud.origin - 1.5, 3.0});
    auto tree = std::make_shared<SceneFrame>();
    tree->svo = build_svo(sorted, 5);
    tree->attributes.colors = mean_colors(tree->svo, cloud, sorted);
    tree->attributes.normals = mean_normal_lines(tree->svo, cloud, sorted);
    tree->radii.assign(tree->svo.node_count(), 0.1f);
    tree->normals_estimated = true;
    DrawOptions options = plain(DrawMode::surfel);
    options.pixel_size = 12.0f;
    options.lighting = true;
    const Image image = picture(tree, front_camera(), options);
    EXPECT_LT(count_near(image, kBackground, 0), image.pixels.size() * 9 / 10);
    if (seed == 0) first = image;
    EXPECT_EQ(largest_difference(first, image), 0) << seed;
  }
}

}  // namespace
}  // namespace pointreel::unknown_signs_test
