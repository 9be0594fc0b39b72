#include "tests/client/renderer_test.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "client/render/opengl/gl_renderer.h"
#include "tests/read_alpha.h"

namespace pointreel::renderer_test {
namespace {

INSTANTIATE_TEST_SUITE_P(, RendererTest, kBothRenderers, renderer_name);

TEST_P(RendererTest, draws_each_colour_at_its_place_in_every_mode) {
  const PointCloud cloud = asymmetric_cloud();
  const auto frame = frame_of(cloud);
  for (const char up : {'y', 'z'}) {
    Camera camera = front_camera();
    camera.up = up;
    if (up == 'z') camera.orbit(0.0, 1.5);  // from above, so that the normals face the eye
    for (const DrawMode mode : kModes) {
      const Image image = picture(frame, camera, plain(mode));
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        const glm::ivec2 at = pixel_of(camera, cloud.world(i));
        EXPECT_LE(difference(image.at(at.x, at.y), eight_bits(cloud.colors[i])), 2)
            << "mode " << static_cast<int>(mode) << " up " << up << " point " << i;
        EXPECT_GE(count_near(image, eight_bits(cloud.colors[i])), 20u);
      }
      EXPECT_EQ(difference(image.at(1, 1), kBackground), 0);
      EXPECT_GT(count_near(image, kBackground, 0), image.pixels.size() * 3 / 4);
      EXPECT_EQ(stats_.drawn, 4u);
    }
  }
}

TEST_P(RendererTest, shows_the_scene_from_the_right_when_the_eye_moves_right) {
  PointCloud cloud;
  add(cloud, {0.04f, 0.04f, 0.8f}, kFront, kRed, 0.1f);  // nearer than the target
  const auto frame = frame_of(cloud);
  Camera camera = front_camera();
  camera.orbit(0.4, 0.0);
  for (const DrawMode mode : kModes) {
    const Image image = picture(frame, camera, plain(mode));
    const glm::ivec2 at = pixel_of(camera, cloud.world(0));
    EXPECT_LT(at.x, kSize.x / 2 - 5);
    EXPECT_LE(difference(image.at(at.x, at.y), glm::u8vec3(255, 0, 0)), 2);
  }
}

TEST_P(RendererTest, draws_the_same_far_from_the_origin_of_the_world) {
  PointCloud cloud = asymmetric_cloud();
  Camera camera = front_camera();
  for (const DrawMode mode : kModes) {
    cloud.origin = glm::dvec3(0.0);
    camera.target = glm::dvec3(0.0);
    const Image here = picture(frame_of(cloud), camera, plain(mode));
    cloud.origin = camera.target = glm::dvec3(1048576.0, -3145728.0, 7340032.0);
    const Image there = picture(frame_of(cloud), camera, plain(mode));
    EXPECT_EQ(largest_difference(here, there), 0);
  }
}

TEST_P(RendererTest, draws_only_the_background_for_an_empty_frame_or_none) {
  for (const DrawMode mode : kModes) {
    picture(frame_of(asymmetric_cloud()), front_camera(), plain(mode));
    for (const auto& frame : {std::shared_ptr<SceneFrame>(), std::make_shared<SceneFrame>()}) {
      const Image image = picture(frame, front_camera(), plain(mode));
      EXPECT_EQ(count_near(image, kBackground, 0), image.pixels.size());
      EXPECT_EQ(stats_.drawn, 0u);
    }
  }
}

TEST_P(RendererTest, culls_surfels_that_face_away_but_not_those_of_unknown_orientation) {
  const auto pixels_of = [&](const glm::vec3& n) {
    PointCloud cloud;
    add(cloud, glm::vec3(0.0f), n, kOrange, 0.2f);
    DrawOptions options = plain(DrawMode::surfel);
    options.scales = {1.0f, 1.0f};
    const Image image = picture(frame_of(cloud), front_camera(), options);
    EXPECT_EQ(count_near(image, eight_bits(kOrange), 1) + count_near(image, kBackground, 0),
              image.pixels.size());
    return count_near(image, eight_bits(kOrange), 1);
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::size_t facing = pixels_of(kFront);
  EXPECT_GT(facing, 100u);
  EXPECT_EQ(pixels_of(-kFront), 0u);
  EXPECT_EQ(pixels_of(glm::vec3(0.0f)), facing);
  EXPECT_EQ(pixels_of(glm::vec3(nan)), facing);
}

TEST_P(RendererTest, ignores_the_sign_of_estimated_normals) {
  for (const DrawMode mode : kModes) {
    DrawOptions options = plain(mode);
    options.lighting = true;
    std::vector<Image> images;
    for (const float sign : {1.0f, -1.0f}) {
      PointCloud cloud;
      add(cloud, glm::vec3(0.04f), sign * glm::normalize(glm::vec3(0.3f, 0.2f, 1.0f)), kOrange,
          0.2f);
      const auto frame = frame_of(cloud);
      frame->normals_estimated = true;
      images.push_back(picture(frame, front_camera(), options));
    }
    EXPECT_EQ(largest_difference(images[0], images[1]), 0) << static_cast<int>(mode);
    EXPECT_LT(count_near(images[0], kBackground, 0), images[0].pixels.size() - 20);
  }
}

TEST_P(RendererTest, draws_a_cloud_without_normals_or_colours_in_grey) {
  PointCloud cloud;
  cloud.positions = {{0.3f, 0.2f, 0.0f}};
  cloud.radii = {0.1f};
  const auto frame = frame_of(cloud);
  for (const DrawMode mode : kModes) {
    const Image image = picture(frame, front_camera(), plain(mode));
    const glm::ivec2 at = pixel_of(front_camera(), cloud.world(0));
    EXPECT_LE(difference(image.at(at.x, at.y), glm::u8vec3(0xd0)), 1);
  }
}

TEST_P(RendererTest, makes_colours_from_the_normals_where_they_are_asked_for) {
  PointCloud cloud;
  const glm::vec3 n = glm::normalize(glm::vec3(0.6f, -0.3f, 0.74f));
  cloud.positions = {{0.3f, 0.2f, 0.0f}};
  cloud.normals = {n};
  cloud.radii = {0.1f};
  const auto frame = frame_of(cloud);
  for (const DrawMode mode : kModes) {
    DrawOptions options = plain(mode);
    options.color = ColorSource::normals;
    const Image image = picture(frame, front_camera(), options);
    const glm::ivec2 at = pixel_of(front_camera(), cloud.world(0));
    const glm::u8vec3 expected(127.5f + 127.5f * n);
    EXPECT_LE(difference(image.at(at.x, at.y), expected), 2) << static_cast<int>(mode);
  }
}

TEST_P(RendererTest, lights_surfaces_that_face_the_light_more_brightly) {
  for (const DrawMode mode : kModes) {
    const auto brightness = [&](const glm::vec3& n) {
      PointCloud cloud;
      add(cloud, glm::vec3(0.04f), n, {}, 0.2f);
      cloud.colors.clear();
      DrawOptions options = plain(mode);
      options.lighting = true;
      const glm::ivec2 at = pixel_of(front_camera(), cloud.world(0));
      return picture(frame_of(cloud), front_camera(), options).at(at.x, at.y).x;
    };
    EXPECT_GT(brightness(kFront), brightness(glm::normalize(glm::vec3(0.9f, 0.0f, 0.4f))) + 20);
  }
}

TEST_P(RendererTest, hardly_darkens_colours_that_have_light_in_them_already) {
  for (const DrawMode mode : kModes) {
    const auto brightness = [&](ColorSource color) {
      PointCloud cloud;
      add(cloud, glm::vec3(0.04f), glm::normalize(glm::vec3(0.9f, 0.0f, 0.4f)),
          glm::u16vec3(0xd0d0), 0.2f);
      DrawOptions options = plain(mode);
      options.lighting = true;
      options.color = color;
      const glm::ivec2 at = pixel_of(front_camera(), cloud.world(0));
      return picture(frame_of(cloud), front_camera(), options).at(at.x, at.y).x;
    };
    EXPECT_GT(brightness(ColorSource::colors), 190);
    EXPECT_LT(brightness(ColorSource::plain), 170);
  }
}

TEST_P(RendererTest, lights_voxels_of_few_pixels_as_the_surface_that_they_are_of) {
  PointCloud cloud;
  for (int i = 0; i < 200; ++i)
    cloud.positions.push_back({std::fmod(0.618f * static_cast<float>(i), 2.0f) - 1.0f,
                               0.01f * static_cast<float>(i) - 1.0f, 0.0f});
  DrawOptions options = plain(DrawMode::voxel);
  options.lighting = true;
  options.background = glm::vec3(0.0f);
  Camera camera = front_camera();
  camera.orbit(0.5, -0.7);  // from below, where the light does not shine
  const Image image = picture(frame_of(cloud, 7), camera, options);
  std::size_t drawn = 0;
  for (const glm::u8vec3& pixel : image.pixels) {
    if (pixel.x == 0) continue;
    ++drawn;
    ASSERT_GT(pixel.x, 190);
  }
  EXPECT_GT(drawn, 150u);
}

TEST_P(RendererTest, shows_the_closest_of_points_that_overlap) {
  PointCloud cloud;
  add(cloud, {-0.1f, 0.0f, 0.0f}, kFront, kRed, 0.2f);
  add(cloud, {0.1f, 0.0f, 0.001f}, kFront, kGreen, 0.2f);
  DrawOptions options = plain(DrawMode::point);
  options.adaptive_points = true;
  const Image image = picture(frame_of(cloud), front_camera(), options);
  const glm::ivec2 left = pixel_of(front_camera(), {-0.05, 0.0, 0.0}),
                   right = pixel_of(front_camera(), {0.05, 0.0, 0.0});
  EXPECT_LE(difference(image.at(left.x, left.y), {255, 0, 0}), 2);
  EXPECT_LE(difference(image.at(right.x, right.y), {0, 255, 0}), 2);
}

TEST_P(RendererTest, draws_an_isolated_surfel_as_a_disc_of_its_radius_and_orientation) {
  DrawOptions options = plain(DrawMode::surfel);
  options.scales = {1.0f, 1.0f};
  Camera camera = front_camera();
  const double f = 0.5 * kSize.y / std::tan(0.5 * camera.fov_y) / camera.distance;
  // The camera looks down at 0.7 rad. The first normal is the pole of the surfel frame.
  camera.orbit(0.0, 0.7);
  for (const glm::vec3& n : {glm::vec3(0, 1, 0), kFront, glm::normalize(glm::vec3(0.5f, 1, 1)),
                             glm::normalize(glm::vec3(-0.8f, 0.3f, 0.6f))}) {
    PointCloud cloud;
    add(cloud, glm::vec3(0.0f), n, kRed, 0.5f);
    const Image image = picture(frame_of(cloud), camera, options);
    const double area = std::numbers::pi * 0.25 * f * f * glm::dot(glm::dvec3(n), camera.axes()[2]);
    EXPECT_NEAR(static_cast<double>(count_near(image, {255, 0, 0})), area, 0.06 * area);
  }
}

TEST_P(RendererTest, blends_splats_by_weight_in_linear_light) {
  PointCloud cloud;
  add(cloud, {-0.1f, 0.0f, 0.0f}, kFront, kRed, 0.2f);
  add(cloud, {0.1f, 0.0f, 0.0f}, kFront, kGreen, 0.2f);
  const glm::ivec2 size(241, 181);  // both odd, so that a pixel is in the middle
  const Image image = picture(frame_of(cloud), front_camera(), plain(DrawMode::surfel), size);
  EXPECT_LE(difference(image.at(120, 90), glm::u8vec3(188, 188, 0)), 1);
}

TEST_P(RendererTest, does_not_saturate_under_thousands_of_splats_on_one_pixel) {
  PointCloud cloud;
  for (int i = 0; i < 20000; ++i) add(cloud, glm::vec3(0.0f), kFront, kOrange, 0.05f);
  const Image image = picture(frame_of(cloud), front_camera(), plain(DrawMode::surfel));
  EXPECT_LE(difference(image.at(kSize.x / 2, kSize.y / 2), eight_bits(kOrange)), 1);
}

TEST_P(RendererTest, hides_far_surfaces_behind_near_ones_in_any_order) {
  for (const bool front_first : {true, false}) {
    PointCloud cloud;
    const auto add_red = [&] { add(cloud, {0.04f, 0.04f, 0.9f}, kFront, kRed, 0.1f); };
    if (front_first) add_red();
    add(cloud, {0.04f, 0.04f, -0.9f}, kFront, kGreen, 0.1f);
    if (!front_first) add_red();
    const glm::ivec2 at = pixel_of(front_camera(), {0.04, 0.04, 0.9});
    for (const DrawMode mode : kModes) {
      const Image image = picture(frame_of(cloud), front_camera(), plain(mode));
      EXPECT_LE(difference(image.at(at.x, at.y), glm::u8vec3(255, 0, 0)), 1)
          << "mode " << static_cast<int>(mode) << " front first " << front_first;
    }
  }
}

TEST_P(RendererTest, orders_depths_a_hundred_thousand_near_plane_distances_away) {
  Camera camera = front_camera();
  camera.distance = 1.0;
  const float far = static_cast<float>(1e5 * camera.near_plane());
  for (const bool front_first : {true, false}) {
    PointCloud cloud;
    const auto add_red = [&] { add(cloud, {0.0f, 0.0f, 1.0f - far}, kFront, kRed, 1.0f); };
    if (front_first) add_red();
    add(cloud, {0.0f, 0.0f, 1.0f - far * 1.0001f}, kFront, kGreen, 0.001f);
    if (!front_first) add_red();
    const auto frame = frame_of(cloud);
    Image image = picture(frame, camera, plain(DrawMode::point));
    EXPECT_LE(difference(image.at(kSize.x / 2, kSize.y / 2), glm::u8vec3(255, 0, 0)), 1);
    // Surfels must be further apart than the tolerance of the visibility pass, which is twice the
    // radius.
    frame->cloud.positions[front_first ? 1 : 0].z = 1.0f - far * 1.03f;
    frame->cloud.radii[front_first ? 1 : 0] = 1.0f;
    image = picture(frame_of(frame->cloud), camera, plain(DrawMode::surfel));
    EXPECT_LE(difference(image.at(kSize.x / 2, kSize.y / 2), glm::u8vec3(255, 0, 0)), 1);
  }
}

TEST_P(RendererTest, fills_the_lower_half_with_a_floor_that_crosses_the_near_plane) {
  PointCloud cloud;
  add(cloud, {0.0f, -0.5f, 0.0f}, {0.0f, 1.0f, 0.0f}, kGreen, 100.0f);
  Camera camera = front_camera();  // the eye is above the middle of the floor
  const Image image = picture(frame_of(cloud), camera, plain(DrawMode::surfel));
  const std::size_t green = count_near(image, {0, 255, 0}),
                    background = count_near(image, kBackground, 0);
  EXPECT_EQ(green + background, image.pixels.size());
  EXPECT_NEAR(static_cast<double>(green), 0.5 * static_cast<double>(image.pixels.size()),
              0.03 * static_cast<double>(image.pixels.size()));
  EXPECT_LE(difference(image.at(kSize.x / 2, kSize.y - 1), {0, 255, 0}), 2);
  EXPECT_EQ(difference(image.at(kSize.x / 2, 0), kBackground), 0);
}

TEST_P(RendererTest, handles_surfels_around_and_at_the_eye) {
  PointCloud cloud;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(-0.02f, 0.02f);
  for (int i = 0; i < 300; ++i) {
    const glm::vec3 n(unit(random), unit(random), unit(random));
    add(cloud, glm::vec3(unit(random), unit(random), 4.0f + unit(random)),
        i % 3 ? glm::normalize(n) : glm::vec3(0.0f), kOrange, 0.02f);
  }
  add(cloud, {0.0f, 0.0f, 4.0f}, glm::vec3(0.0f), kOrange, 0.02f);
  const Image image = picture(frame_of(cloud), front_camera(), plain(DrawMode::surfel));
  EXPECT_EQ(count_near(image, eight_bits(kOrange), 2) + count_near(image, kBackground, 0),
            image.pixels.size());
}

TEST_P(RendererTest, draws_voxels_in_the_size_of_their_level_without_gaps) {
  // A full plate of 8 x 8 voxels of the 3-unit cube at depth 5, normals unknown.
  PointCloud cloud;
  const float cell = 3.0f / 32.0f;
  for (int y = -4; y < 4; ++y) {
    for (int x = -4; x < 4; ++x) {
      add(cloud, {(0.5f + static_cast<float>(x)) * cell, (0.5f + static_cast<float>(y)) * cell, 0},
          glm::vec3(0.0f), kRed, 0.1f);
    }
  }
  Camera camera = front_camera();
  const Image image = picture(frame_of(cloud), camera, plain(DrawMode::voxel));
  // The front faces lie at z = one cell: z = 0 is a boundary and belongs to the cell above it.
  const double f = 0.5 * kSize.y / std::tan(0.5 * camera.fov_y) / (camera.distance - cell);
  const double side = 8.0 * cell * f;
  EXPECT_NEAR(static_cast<double>(count_near(image, {255, 0, 0})), side * side, 0.04 * side * side);
  const int half = static_cast<int>(0.5 * side) - 1;
  for (int y = -half; y <= half; ++y) {
    for (int x = -half; x <= half; ++x) {
      ASSERT_LE(difference(image.at(kSize.x / 2 + x, kSize.y / 2 + y), {255, 0, 0}), 2);
    }
  }
}

TEST_P(RendererTest, shows_the_faces_of_a_cube_towards_the_eye_from_every_side) {
  PointCloud cloud;
  add(cloud, glm::vec3(0.0f), glm::vec3(0.0f), glm::u16vec3(0xffff), 0.1f);
  const auto frame = frame_of(cloud, 1);  // the voxel from 0 to 1.5
  DrawOptions options = plain(DrawMode::voxel);
  options.lighting = true;
  for (int octant = 0; octant < 8; ++octant) {
    Camera camera = front_camera();
    camera.target = glm::dvec3(0.75);
    camera.distance = 8.0;
    camera.orbit(0.785 + 1.5708 * (octant & 3), octant & 4 ? 0.6 : -0.6);
    const Image image = picture(frame, camera, options);
    // White, dimmed by the light on the face, which comes from the upper left in eye space.
    const glm::dvec3 light = camera.axes() * glm::normalize(glm::dvec3(-0.35, 0.45, 1.0));
    const glm::dvec3 sign = glm::sign(camera.eye() - camera.target);
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 normal(0.0);
      normal[axis] = sign[axis];
      const glm::ivec2 at = pixel_of(camera, camera.target + 0.75 * normal);
      // Colours of its own are lit weakly.
      const double linear = 0.7 + 0.3 * (0.4 + 0.6 * std::max(glm::dot(normal, light), 0.0));
      const double srgb = 255.0 * (1.055 * std::pow(linear, 1 / 2.4) - 0.055);
      EXPECT_NEAR(image.at(at.x, at.y).x, srgb, 2.0) << "octant " << octant << " axis " << axis;
    }
  }
}

TEST_P(RendererTest, redraws_a_static_scene_identically_and_reuses_its_cut) {
  const auto frame = frame_of(asymmetric_cloud());
  for (const DrawMode mode : kModes) {
    const Image first = picture(frame, front_camera(), plain(mode));
    const DrawStats first_stats = stats_;
    const Image second = picture(frame, front_camera(), plain(mode));
    EXPECT_EQ(largest_difference(first, second), 0);
    EXPECT_EQ(stats_.drawn, first_stats.drawn);
    EXPECT_EQ(stats_.visited, first_stats.visited);
    EXPECT_EQ(stats_.cut_ms, 0.0);
    if (mode == DrawMode::voxel) {
      EXPECT_GT(first_stats.cut_ms, 0.0);
      Camera moved = front_camera();
      moved.orbit(0.3, 0.0);
      EXPECT_GT(largest_difference(second, picture(frame, moved, plain(mode))), 50);
      EXPECT_GT(stats_.cut_ms, 0.0);
    }
  }
}

TEST_P(RendererTest, draws_the_leaves_of_a_tree_as_surfels_and_points_and_reuses_its_cut) {
  const auto leaves = std::make_shared<SceneFrame>(*frame_of(asymmetric_cloud()));
  leaves->cloud = leaf_centers(leaves->svo);
  const auto tree = std::make_shared<SceneFrame>(*leaves);
  tree->cloud = {};
  tree->radii.assign(tree->svo.node_count(), 0.1f);
  for (std::size_t i = tree->svo.internal_count(); i < tree->svo.node_count(); ++i) {
    leaves->cloud.normals.push_back(glm::vec3(tree->attributes.normals[i]) / 32767.0f);
    leaves->cloud.colors.push_back(tree->attributes.colors[i]);
    leaves->cloud.radii.push_back(0.1f);
  }
  for (const DrawMode mode : {DrawMode::surfel, DrawMode::point}) {
    const Image expected = picture(leaves, front_camera(), plain(mode));
    EXPECT_EQ(stats_.visited, 0u);
    const Image drawn = picture(tree, front_camera(), plain(mode));
    EXPECT_LE(largest_difference(expected, drawn), 1);
    EXPECT_EQ(stats_.drawn, tree->svo.leaf_count());
    EXPECT_GT(stats_.cut_ms, 0.0);
    EXPECT_EQ(largest_difference(drawn, picture(tree, front_camera(), plain(mode))), 0);
    EXPECT_EQ(stats_.cut_ms, 0.0);
    EXPECT_EQ(stats_.visited, tree->svo.node_count());

    // From far away the voxels are one node, and beside the picture there is none.
    Camera far = front_camera();
    far.distance = 1e4;
    picture(tree, far, plain(mode));
    EXPECT_EQ(stats_.drawn, 1u);
    EXPECT_EQ(stats_.below_pixel, tree->svo.leaf_count() - 1);
    EXPECT_EQ(stats_.out_of_view, 0u);
    Camera beside = front_camera();
    beside.target.x += 100.0;
    picture(tree, beside, plain(mode));
    EXPECT_EQ(stats_.drawn, 0u);
    EXPECT_EQ(stats_.out_of_view, tree->svo.leaf_count());
    EXPECT_EQ(stats_.below_pixel, 0u);
  }
}

TEST_P(RendererTest, changes_colours_by_at_most_one_step_with_the_order_of_surfels) {
  std::mt19937 random(9);
  std::normal_distribution<float> normal;
  PointCloud cloud, shuffled;
  // There are so many surfels that holes are found by only some of the backs.
  for (int i = 0; i < 40000; ++i) {
    const glm::vec3 n = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    add(cloud, n, n, glm::u16vec3(random(), random(), random()), 0.012f);
  }
  std::vector<std::size_t> order(cloud.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), random);
  for (const std::size_t i : order) {
    add(shuffled, cloud.positions[i], cloud.normals[i], cloud.colors[i], cloud.radii[i]);
  }
  const Image a = picture(frame_of(cloud), front_camera(), plain(DrawMode::surfel));
  const Image b = picture(frame_of(shuffled), front_camera(), plain(DrawMode::surfel));
  EXPECT_LT(count_near(a, kBackground, 0), a.pixels.size() * 3 / 4);
  EXPECT_LE(largest_difference(a, b), 1);
}

TEST_P(RendererTest, sets_alpha_exactly_where_it_draws) {
  for (const DrawMode mode : kModes) {
    const Image image = picture(frame_of(asymmetric_cloud()), front_camera(), plain(mode));
    const auto alpha = read_alpha(*renderer_);
    ASSERT_EQ(alpha.size(), image.pixels.size());
    for (std::size_t i = 0; i < alpha.size(); ++i)
      ASSERT_EQ(alpha[i] > 0, difference(image.pixels[i], kBackground) > 0);
  }
}

TEST_P(RendererTest, leaves_no_trace_of_a_larger_frame_another_mode_or_another_size) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  PointCloud large;
  for (int i = 0; i < 1000; ++i) {
    add(large, {unit(random), unit(random), unit(random)}, kFront, kGreen, 0.1f);
  }
  const auto small = frame_of(asymmetric_cloud());
  for (const DrawMode mode : kModes) {
    const Image before = picture(small, front_camera(), plain(mode));
    for (const DrawMode other : kModes) {
      picture(frame_of(large), front_camera(), plain(other), {64, 300});
      EXPECT_EQ(largest_difference(before, picture(small, front_camera(), plain(mode))), 0);
      picture(small, front_camera(), plain(other));
      EXPECT_EQ(largest_difference(before, picture(small, front_camera(), plain(mode))), 0);
    }
  }
}

}  // namespace
}  // namespace pointreel::renderer_test
