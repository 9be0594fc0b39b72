#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <png.h>

#include "client/render/opengl/gl_renderer.h"
#include "tests/client/renderer_test.h"

namespace pointreel::renderer_picture_test {
namespace {

TEST_P(RendererTest, presents_the_same_bytes_that_it_reads_back) {
  gl::Texture color = gl::make_texture(GL_RGBA8, kSize.x, kSize.y);
  gl::Texture depth = gl::make_texture(GL_DEPTH_COMPONENT32F, kSize.x, kSize.y);
  const Result<gl::Framebuffer> target = gl::make_framebuffer(color, depth);
  ASSERT_TRUE(target);
  const auto expect_the_same = [&](const Image& image) {
    renderer_->present(target->name());
    std::vector<glm::u8vec3> bottom_up(image.pixels.size());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTextureImage(color.name(), 0, GL_RGB, GL_UNSIGNED_BYTE,
                      static_cast<GLsizei>(bottom_up.size() * 3), bottom_up.data());
    for (int y = 0; y < kSize.y; ++y) {
      for (int x = 0; x < kSize.x; ++x) {
        const auto i = static_cast<std::size_t>((kSize.y - 1 - y) * kSize.x + x);
        ASSERT_EQ(difference(image.at(x, y), bottom_up[i]), 0);
      }
    }
  };
  // Large and small points, some partly outside the picture.
  Camera near = front_camera();
  near.distance *= 0.3;
  Camera far = front_camera();
  far.distance *= 20.0;
  const auto frame = frame_of(asymmetric_cloud());
  for (const Camera& camera : {front_camera(), near, far}) {
    for (const DrawMode mode : kModes) {
      DrawOptions options = plain(mode);
      options.background = {0.37f, 0.51f, 0.83f};
      expect_the_same(picture(frame, camera, options));
      options.point_size = 31.0f;
      options.splatting = Splatting::enlarged;
      expect_the_same(picture(frame, camera, options));
      options.floor = FloorGrid{{glm::dvec3(-1.0), glm::dvec3(1.0)}, 'y'};
      expect_the_same(picture(frame, camera, options));
    }
  }
  expect_the_same(picture(nullptr, front_camera(), plain(DrawMode::surfel)));
}

TEST_P(RendererTest, takes_colours_from_the_frame_or_from_its_normals_or_none) {
  PointCloud cloud = asymmetric_cloud();
  const glm::vec3 askew = glm::normalize(glm::vec3(0.3f, -0.2f, 1.0f));
  for (glm::vec3& normal : cloud.normals) normal = askew;
  const auto frame = frame_of(cloud);
  const glm::u8vec3 of_normal(glm::round((askew + 1.0f) * 127.5f)), plain_color(0xd0);
  for (const DrawMode mode : kModes) {
    DrawOptions options = plain(mode);
    const Image own = picture(frame, front_camera(), options);
    options.color = ColorSource::normals;
    const Image normals = picture(frame, front_camera(), options);
    options.color = ColorSource::plain;
    const Image gray = picture(frame, front_camera(), options);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const glm::ivec2 at = pixel_of(front_camera(), cloud.world(i));
      EXPECT_LE(difference(own.at(at.x, at.y), eight_bits(cloud.colors[i])), 2);
      EXPECT_LE(difference(normals.at(at.x, at.y), of_normal), 2) << static_cast<int>(mode);
      EXPECT_LE(difference(gray.at(at.x, at.y), plain_color), 2);
    }
    options.color = ColorSource::colors;
    EXPECT_EQ(largest_difference(own, picture(frame, front_camera(), options)), 0);
    PointCloud colorless = cloud;
    colorless.colors.clear();
    EXPECT_EQ(largest_difference(gray, picture(frame_of(colorless), front_camera(), options)), 0)
        << "what has no colours is grey";
  }
}

TEST_P(RendererTest, finds_the_world_position_of_a_pixel) {
  for (const glm::dvec3& offset : {glm::dvec3(0.0), glm::dvec3(4e6, -7e6, 2e5)}) {
    auto frame = frame_of(asymmetric_cloud());
    frame->cloud.origin += offset;
    frame->svo.cube.origin += offset;
    for (const char up : {'y', 'z'}) {
      Camera camera = front_camera();
      camera.target += offset;
      camera.up = up;
      camera.orbit(0.2, up == 'z' ? 1.4 : 0.1);
      std::vector<DrawOptions> ways = {plain(DrawMode::voxel), plain(DrawMode::point)};
      for (int i = 0; i < static_cast<int>(kEnumNames<Splatting>.size()); ++i) {
        ways.push_back(plain(DrawMode::surfel));
        ways.back().splatting = static_cast<Splatting>(i);
      }
      for (const DrawOptions& options : ways) {
        picture(frame, camera, options);
        for (std::size_t i = 0; i < frame->cloud.size(); ++i) {
          const glm::dvec3 world = frame->cloud.world(i);
          const glm::ivec2 at = pixel_of(camera, world);
          // Half a voxel's diagonal, or the distance by which surfels are pushed back: both are
          // about 0.1.
          const auto found = renderer_->point_at(glm::dvec2(at) + 0.5);
          ASSERT_TRUE(found) << name(options.splatting);
          EXPECT_LT(glm::distance(*found, world), 0.21) << name(options.splatting);
          const glm::ivec2 again = pixel_of(camera, *found);
          EXPECT_LE(std::max(std::abs(again.x - at.x), std::abs(again.y - at.y)), 1);
        }
        EXPECT_FALSE(renderer_->point_at({3.0, 3.0}));
      }
    }
  }
}

TEST_P(RendererTest, finds_the_nearest_drawn_pixel_for_one_beside_it) {
  PointCloud cloud;
  add(cloud, {0.3f, 0.2f, 0.1f}, kFront, kRed, 0.1f);
  const auto frame = frame_of(cloud);
  DrawOptions options = plain(DrawMode::point);
  const glm::ivec2 at = pixel_of(front_camera(), cloud.world(0));
  picture(frame, front_camera(), options);
  for (const glm::ivec2& beside : {glm::ivec2(6, 0), glm::ivec2(-6, 0), glm::ivec2(0, 7)}) {
    const auto found = renderer_->point_at(glm::dvec2(at + beside) + 0.5);
    ASSERT_TRUE(found);
    const glm::ivec2 seen = pixel_of(front_camera(), *found);
    // The point is a square of five pixels.
    EXPECT_LE(std::max(std::abs(seen.x - at.x), std::abs(seen.y - at.y)), 3);
    EXPECT_NEAR(found->z, 0.1, 0.05);  // it falls off from the middle
  }
  EXPECT_FALSE(renderer_->point_at(glm::dvec2(at) + 30.0));
  // The point is that of the last picture, whatever its size, and there is none outside of it.
  picture(frame, front_camera(), options, {100, 400});
  EXPECT_TRUE(
      renderer_->point_at(glm::dvec2(pixel_of(front_camera(), cloud.world(0), {100, 400})) + 0.5));
  for (const glm::dvec2& outside :
       {glm::dvec2(-1.0, 50.0), glm::dvec2(50.0, -1.0), glm::dvec2(101.0, 50.0),
        glm::dvec2(50.0, 401.0), glm::dvec2(std::nan(""), 50.0), glm::dvec2(1e300, 1e300)})
    EXPECT_FALSE(renderer_->point_at(outside));
  picture(nullptr, front_camera(), options, {1, 1});
  EXPECT_FALSE(renderer_->point_at({0.5, 0.5}));
}

TEST_P(RendererTest, exposes_the_picture_as_a_texture_of_the_same_bytes) {
  EXPECT_EQ(renderer_->texture(), 0u);
  EXPECT_FALSE(renderer_->point_at({1.0, 1.0}));
  for (const glm::ivec2& size : {kSize, glm::ivec2(33, 57)}) {
    const Image image =
        picture(frame_of(asymmetric_cloud()), front_camera(), plain(DrawMode::surfel), size);
    const GLuint texture = renderer_->texture();
    GLint format = 0, alpha = 0, width = 0;
    glGetTextureLevelParameteriv(texture, 0, GL_TEXTURE_INTERNAL_FORMAT, &format);
    glGetTextureLevelParameteriv(texture, 0, GL_TEXTURE_WIDTH, &width);
    glGetTextureParameteriv(texture, GL_TEXTURE_SWIZZLE_A, &alpha);
    EXPECT_EQ(format, GL_RGBA8);
    EXPECT_EQ(alpha, GL_ONE);
    ASSERT_EQ(width, size.x);
    std::vector<glm::u8vec4> bottom_up(image.pixels.size());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTextureImage(texture, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                      static_cast<GLsizei>(bottom_up.size() * 4), bottom_up.data());
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        const auto i = static_cast<std::size_t>((size.y - 1 - y) * size.x + x);
        ASSERT_EQ(difference(image.at(x, y), glm::u8vec3(bottom_up[i])), 0);
      }
    }
  }
}

TEST_P(RendererTest, draws_the_same_with_a_second_renderer_in_one_context) {
  const auto frame = frame_of(asymmetric_cloud());
  const Image first = picture(frame, front_camera(), plain(DrawMode::point));
  const std::unique_ptr<Renderer> second = make_renderer();
  ASSERT_TRUE(second->draw(frame, front_camera(), kSize / 2, plain(DrawMode::surfel)));
  ASSERT_TRUE(second->draw(frame, front_camera(), kSize, plain(DrawMode::point)));
  EXPECT_EQ(largest_difference(first, *second->read_pixels()), 0);
  EXPECT_EQ(largest_difference(first, picture(frame, front_camera(), plain(DrawMode::point))), 0);
}

TEST_P(RendererTest, refuses_an_oversized_picture_and_reads_none_before_the_first) {
  EXPECT_FALSE(renderer_->read_pixels());
  EXPECT_FALSE(renderer_->draw(nullptr, Camera{}, {0, 100}, DrawOptions{}));
  const Result<DrawStats> huge = renderer_->draw(nullptr, Camera{}, {1 << 24, 1}, DrawOptions{});
  ASSERT_FALSE(huge);
  EXPECT_NE(huge.error().message.find("16777216x1"), std::string::npos);
}

TEST_P(RendererTest, names_a_missing_shader) {
  const auto program_of = [](std::string_view vertex) {
    return gl::make_program(std::array{gl::Stage{GL_VERTEX_SHADER, {vertex}},
                                       gl::Stage{GL_FRAGMENT_SHADER, {"shaders/flat.frag.glsl"}}});
  };
  const Result<gl::Program> program = program_of("absent.glsl");
  ASSERT_FALSE(program);
  EXPECT_NE(program.error().message.find("absent.glsl"), std::string::npos);
  // The source shared by all stages comes first, so this includes it twice. The compiler's message
  // is passed on.
  const Result<gl::Program> wrong = program_of("shaders/common.glsl");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("common.glsl does not compile: "), std::string::npos)
      << wrong.error().message;
  EXPECT_EQ(wrong.error().message.find('\n'), std::string::npos);

  gl::LateProgram late({{GL_VERTEX_SHADER, {"absent.glsl"}}});
  for (int twice = 0; twice < 2; ++twice) {
    const auto used = late.use();
    ASSERT_FALSE(used);
    EXPECT_NE(used.error().message.find("absent.glsl"), std::string::npos);
  }
}

TEST(Image, is_written_as_png_from_the_top_row_with_the_path_in_errors) {
  Image image{3, 2, {}};
  image.pixels = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {1, 2, 3}, {4, 5, 6}, {250, 128, 7}};
  const std::string path =
      (std::filesystem::temp_directory_path() / "pointreel-image-test.png").string();
  const Result<void> written = write_png(path, image);
  ASSERT_TRUE(written) << written.error().message;
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_file(&png, path.c_str()));
  ASSERT_EQ(png.width, 3u);
  ASSERT_EQ(png.height, 2u);
  png.format = PNG_FORMAT_RGB;
  std::vector<glm::u8vec3> pixels(6);
  ASSERT_TRUE(png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr));
  EXPECT_EQ(pixels, image.pixels);
  std::filesystem::remove(path);

  const Result<void> refused = write_png("/nonexistent/folder/x.png", image);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("/nonexistent/folder/x.png"), std::string::npos);
}

}  // namespace
}  // namespace pointreel::renderer_picture_test
