#include "client/render/software/software_renderer.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <xxhash.h>

#include "pointreel/cpu.h"
#include "tests/bench/render/image_error.h"
#include "tests/client/renderer_test.h"

namespace pointreel::software_renderer_test {
namespace {

using bench::psnr;

/// Runs bodies on a number of threads of its own, in an order that is not theirs.
Executor executor_of(int threads) {
  return [threads](int count, const std::function<void(int)>& body) {
    std::vector<std::jthread> running;
    for (int t = 0; t < threads; ++t)
      running.emplace_back([=, &body] {
        for (int i = count - 1 - t; i >= 0; i -= threads) body(i);
      });
  };
}

/// A sphere with dents and a few holes, in colours that change slowly, without any function of the
/// system's library, so that it is the same everywhere.
PointCloud dented_sphere(int points) {
  std::mt19937 random(7);
  const auto unit = [&random] { return static_cast<float>(random() >> 8) / 8388608.0f - 1.0f; };
  PointCloud cloud;
  while (static_cast<int>(cloud.size()) < points) {
    // Each by itself, since compilers choose in which order they compute arguments.
    const float z = unit(), y = unit(), x = unit();
    const glm::vec3 p(x, y, z);
    const float square = glm::dot(p, p);
    if (square > 1.0f || square < 0.01f) continue;
    const glm::vec3 n = p / std::sqrt(square);
    const float dent = 0.1f * n.x * n.y;
    const auto from_hole = n - glm::vec3(0.4f, 0.2f, 0.894427f);
    if (glm::dot(from_hole, from_hole) < 0.01f) continue;
    add(cloud, (1.0f - dent) * n, n, glm::u16vec3(32767.0f * (1.0f + n)),
        2.2f / std::sqrt(static_cast<float>(points)));
  }
  return cloud;
}

struct View {
  const char* name;
  Camera camera;
};

std::vector<View> views() {
  View front{"front", front_camera()}, close{"close", front_camera()}, far{"far", front_camera()},
      inside{"inside", front_camera()};
  close.camera.distance = 1.3;
  close.camera.yaw = 0.5;
  far.camera.distance = 30.0;
  inside.camera.distance = 0.4;
  return {front, close, far, inside};
}

std::vector<DrawOptions> all_options() {
  std::vector<DrawOptions> all;
  for (const DrawMode mode : kModes) {
    DrawOptions options = plain(mode);
    options.lighting = true;
    all.push_back(options);
    options.edl = 0.5f;
    options.smooth_outlines = true;
    options.floor = FloorGrid{{glm::dvec3(-1.0), glm::dvec3(1.0)}};
    all.push_back(options);
  }
  for (const bool fill_holes : {true, false}) {
    DrawOptions options = plain(DrawMode::strip);
    options.lighting = true;
    options.fill_holes = fill_holes;
    all.push_back(options);
  }
  for (const auto& splatting : kEnumNames<Splatting>) {
    DrawOptions options = plain(DrawMode::surfel);
    options.splatting = splatting.value;
    options.scales = {1.0f, 1.6f};
    all.push_back(options);
  }
  return all;
}

/// A cloud made ready for all modes.
struct Frames {
  std::shared_ptr<SceneFrame> elements, strips;

  explicit Frames(const PointCloud& cloud)
      : elements(frame_of(cloud, 6)), strips(strip_frame_of(cloud)) {}
  Frames with_unknown_signs() const {
    Frames unknown = *this;
    for (auto* frame : {&unknown.elements, &unknown.strips}) {
      *frame = std::make_shared<SceneFrame>(**frame);
      (*frame)->normals_estimated = true;
    }
    return unknown;
  }
  const std::shared_ptr<SceneFrame>& of(DrawMode mode) const {
    return mode == DrawMode::strip ? strips : elements;
  }
};

/// With light that is computed for each pixel.
std::vector<DrawOptions> lit_options() {
  std::vector<DrawOptions> all;
  for (const auto& [mode, name] : kEnumNames<DrawMode>) {
    DrawOptions options = plain(mode);
    options.light = Light::studio;
    all.push_back(options);
    options.roughness = 0.3f;
    options.smooth_outlines = true;
    options.floor = FloorGrid{{glm::dvec3(-1.0), glm::dvec3(1.0)}};
    all.push_back(options);
  }
  return all;
}

/// With colours that are found for each pixel.
std::vector<DrawOptions> false_colors() {
  std::vector<DrawOptions> all;
  for (const ColorSource color : {ColorSource::curvature, ColorSource::accessibility,
                                  ColorSource::depth, ColorSource::contours}) {
    DrawOptions options = plain(DrawMode::surfel);
    options.color = color;
    options.lighting = true;
    all.push_back(options);
  }
  all.front().light = Light::studio;
  all.back().mode = DrawMode::voxel;
  return all;
}

std::vector<DrawOptions> with(std::vector<DrawOptions> all, const std::vector<DrawOptions>& more) {
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

Image draw_with(Renderer& renderer, const std::shared_ptr<const SceneFrame>& frame,
                const Camera& camera, const DrawOptions& options) {
  const auto stats = renderer.draw(frame, camera, kSize, options);
  EXPECT_TRUE(stats) << stats.error().message;
  return renderer.read_pixels().value();
}

TEST(SoftwareRenderer, draws_the_same_bytes_with_any_number_of_threads_and_without_avx2) {
  const Frames frames(dented_sphere(30'000));
  SoftwareRenderer one(executor_of(1)), three(executor_of(3)), none{Executor{}},
      portable(executor_of(2));
  for (const Frames& all : {frames, frames.with_unknown_signs()}) {
    for (const View& view : views()) {
      for (const DrawOptions& options : with(all_options(), lit_options())) {
        const auto& drawn = all.of(options.mode);
        const Image expected = draw_with(one, drawn, view.camera, options);
        EXPECT_EQ(largest_difference(expected, draw_with(three, drawn, view.camera, options)), 0);
        EXPECT_EQ(largest_difference(expected, draw_with(none, drawn, view.camera, options)), 0);
        set_cpu_feature_mask(0);
        const Image without = draw_with(portable, drawn, view.camera, options);
        set_cpu_feature_mask(~0u);
        EXPECT_EQ(largest_difference(expected, without), 0) << view.name;
      }
    }
  }
}

TEST(SoftwareRenderer, draws_the_same_bytes_on_every_machine) {
  const Frames frames(dented_sphere(20'000));
  SoftwareRenderer renderer(executor_of(2));
  std::vector<std::uint64_t> hashes;
  for (const auto& [mode, name] : kEnumNames<DrawMode>) {
    DrawOptions options = plain(mode);
    options.lighting = true;
    options.edl = 0.5f;
    options.smooth_outlines = true;
    const Image image = draw_with(renderer, frames.of(mode), front_camera(), options);
    hashes.push_back(XXH3_64bits(image.pixels.data(), 3 * image.pixels.size()));
  }
  EXPECT_EQ(hashes, (std::vector<std::uint64_t>{7400415564248274996u, 17834563529761899116u,
                                                15814582844939282249u, 10659770302935167059u}));
}

TEST(SoftwareRenderer, draws_what_opengl_draws_in_every_mode_from_near_and_far) {
  const auto context = OffscreenContext::create();
  ASSERT_TRUE(context) << context.error().message;
  auto opengl = GlRenderer::create();
  ASSERT_TRUE(opengl) << opengl.error().message;
  SoftwareRenderer software(executor_of(2));
  const Frames frames(dented_sphere(30'000));
  for (const Frames& all : {frames, frames.with_unknown_signs()}) {
    for (const View& view : views()) {
      int number = 0;
      for (const DrawOptions& options : with(all_options(), lit_options())) {
        const auto& drawn = all.of(options.mode);
        // The paper's ways to splat depend on the order, which the default of OpenGL changes.
        DrawOptions same = options;
        if (options.splatting != Splatting::normalized) same.instancing = Instancing::attribute;
        const Image expected = draw_with(*opengl, drawn, view.camera, same);
        const Image image = draw_with(software, drawn, view.camera, options);
        // // OpenGL drivers move points and corners to a raster of fractions of pixels.
        EXPECT_GT(psnr(expected, image).value_or(99.0), options.mode == DrawMode::point   ? 37.0
                                                        : options.mode == DrawMode::strip ? 40.0
                                                                                          : 45.0)
            << view.name << ", options " << number
            << (drawn->normals_estimated ? ", signs unknown" : "");
        ++number;
      }
    }
  }
}

TEST(SoftwareRenderer, survives_surfels_that_are_not_numbers_or_reach_everywhere) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kInf = std::numeric_limits<float>::infinity();
  PointCloud cloud = dented_sphere(500);
  for (const float odd : {kNan, kInf, -kInf, 1e30f, -1e30f, 0.0f, -1.0f, 1e-30f}) {
    add(cloud, {odd, 0.0f, 0.0f}, kFront, kRed, 0.1f);
    add(cloud, {0.0f, 0.0f, 0.0f}, {odd, odd, odd}, kRed, 0.1f);
    add(cloud, {0.1f, 0.0f, 0.0f}, kFront, kRed, odd);
    add(cloud, {odd, odd, odd}, {odd, 0.0f, odd}, kRed, odd);
  }
  auto frame = std::make_shared<SceneFrame>();
  frame->cloud = std::move(cloud);
  SoftwareRenderer renderer(executor_of(2));
  for (const View& view : views())
    for (const DrawOptions& options : with(with(all_options(), lit_options()), false_colors()))
      if (options.mode != DrawMode::voxel) draw_with(renderer, frame, view.camera, options);
}

TEST(SoftwareRenderer, survives_vertices_that_are_not_numbers_or_far_away) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kInf = std::numeric_limits<float>::infinity();
  const auto frame = strip_frame_of(dented_sphere(2000));
  std::size_t i = 0;
  for (const float odd : {kNan, kInf, -kInf, 1e30f, -1e30f, 1e-30f, 1e5f}) {
    for (int axis = 0; axis < 3; ++axis) frame->cloud.positions[17 * i++][axis] = odd;
    frame->cloud.normals[17 * i++] = glm::vec3(odd);
  }
  SoftwareRenderer renderer(executor_of(2));
  for (const View& view : views())
    for (const DrawOptions& options : with(all_options(), lit_options()))
      if (options.mode == DrawMode::strip) draw_with(renderer, frame, view.camera, options);
}

/// The mean of the bytes of all colours in a part of the picture.
double brightness(const Image& image, glm::ivec2 from, glm::ivec2 to) {
  double sum = 0.0;
  for (int y = from.y; y < to.y; ++y)
    for (int x = from.x; x < to.x; ++x) {
      const glm::u8vec3 c = image.at(x, y);
      sum += c.r + c.g + c.b;
    }
  return sum / (3.0 * (to.x - from.x) * (to.y - from.y));
}

TEST(SoftwareRenderer, lights_a_sphere_more_on_the_side_of_the_key_light) {
  SoftwareRenderer renderer(executor_of(2));
  DrawOptions options = plain(DrawMode::surfel);
  options.color = ColorSource::plain;
  options.light = Light::studio;
  const Image image =
      draw_with(renderer, frame_of(dented_sphere(30'000), 6), front_camera(), options);
  const glm::ivec2 middle(image.width / 2, image.height / 2), part(image.height / 16);
  const glm::ivec2 step = glm::ivec2(image.height / 8, 0);
  const auto at = [&](glm::ivec2 where) { return brightness(image, where - part, where + part); };
  EXPECT_GT(at(middle - step - glm::ivec2(0, step.x)),
            at(middle + step + glm::ivec2(0, step.x)) + 10);
}

TEST(SoftwareRenderer, darkens_the_floor_where_the_scene_takes_its_light) {
  SoftwareRenderer renderer(executor_of(2));
  DrawOptions options = plain(DrawMode::surfel);
  options.background = glm::vec3(0.8f);
  options.floor = FloorGrid{{glm::dvec3(-1.0), glm::dvec3(1.0)}};
  Camera camera = front_camera();
  camera.pitch = 0.4;
  camera.distance = 6.0;
  const auto frame = frame_of(dented_sphere(30'000), 6);
  const Image flat = draw_with(renderer, frame, camera, options);
  options.light = Light::studio;
  const Image lit = draw_with(renderer, frame, camera, options);
  int darker_left = 0, darker_right = 0;
  for (int y = 0; y < lit.height; ++y)
    for (int x = 0; x < lit.width; ++x)
      // Lines and the figure have other colours than the background.
      if (flat.at(x, y).r == 204 && lit.at(x, y).r < 180)
        ++(x < lit.width / 2 ? darker_left : darker_right);
  EXPECT_GT(darker_right, 50);
  EXPECT_LT(darker_left, darker_right / 2);
}

TEST(SoftwareRenderer, says_what_it_is) {
  EXPECT_NE(SoftwareRenderer(executor_of(1)).describe().find("software"), std::string::npos);
}

}  // namespace
}  // namespace pointreel::software_renderer_test
