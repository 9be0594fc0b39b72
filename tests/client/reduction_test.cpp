// Pictures that are drawn smaller than they are shown.

#include <cmath>
#include <vector>

#include "client/render/opengl/gl_objects.h"
#include "tests/client/drawing_test.h"

namespace pointreel::reduction_test {
namespace {

constexpr glm::ivec2 kSize{97, 61};  // not a multiple of anything
constexpr int kReduction = 4;
constexpr glm::ivec2 kSmaller{25, 16};

class ReductionTest : public DrawingTest {
 protected:
  void SetUp() override {
    DrawingTest::SetUp();
    SceneFrame frame;
    frame.cloud.positions = {{0.4f, 0.25f, 0.0f}};
    frame.cloud.colors = {{0xffff, 0x2000, 0x1000}};
    frame_ = std::make_shared<const SceneFrame>(std::move(frame));
    options_.mode = DrawMode::point;
    options_.lighting = false;
    options_.point_size = 12.0f;
    options_.adaptive_points = false;
    camera_.distance = 3.0;
    options_.reduction = kReduction;
  }

  /// The picture in its full size, from the lowest row.
  std::vector<glm::u8vec4> presented() {
    draw(frame_, camera_, kSize, options_);
    gl::Texture color = gl::make_texture(GL_RGBA8, kSize.x, kSize.y);
    gl::Texture depth = gl::make_texture(GL_DEPTH_COMPONENT32F, kSize.x, kSize.y);
    const Result<gl::Framebuffer> target = gl::make_framebuffer(color, depth);
    if (!target) ADD_FAILURE() << target.error().message;
    renderer_->present(target->name());
    std::vector<glm::u8vec4> pixels(static_cast<std::size_t>(kSize.x * kSize.y));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTextureImage(color.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE,
                      static_cast<GLsizei>(pixels.size() * sizeof(glm::u8vec4)), pixels.data());
    return pixels;
  }

  std::shared_ptr<const SceneFrame> frame_;
  Camera camera_;
  DrawOptions options_;
};

INSTANTIATE_TEST_SUITE_P(, ReductionTest, kBothRenderers, renderer_name);

TEST_P(ReductionTest, draws_the_same_as_a_smaller_picture) {
  const Image reduced = draw(frame_, camera_, kSize, options_);
  options_.reduction = 1;
  options_.point_size /= kReduction;
  const Image smaller = draw(frame_, camera_, kSmaller, options_);
  ASSERT_EQ(glm::ivec2(reduced.width, reduced.height), kSmaller);
  EXPECT_EQ(reduced.pixels, smaller.pixels);
}

TEST_P(ReductionTest, is_enlarged_to_the_full_size_when_presented) {
  const auto shown = [&] {
    const std::vector<glm::u8vec4> pixels = presented();
    // The position and the size of the point.
    glm::dvec2 sum(0.0);
    double count = 0.0;
    for (int y = 0; y < kSize.y; ++y)
      for (int x = 0; x < kSize.x; ++x)
        if (pixels[static_cast<std::size_t>(y * kSize.x + x)].r > 128) {
          sum += glm::dvec2(x, y);
          ++count;
        }
    return glm::dvec3(sum / count, std::sqrt(count));
  };
  const glm::dvec3 reduced = shown();
  options_.reduction = 1;
  const glm::dvec3 whole = shown();
  EXPECT_NEAR(whole.z, 12.0, 0.1);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(reduced[i], whole[i], kReduction) << i;
}

TEST_P(ReductionTest, has_nothing_but_the_point_on_the_background_when_presented) {
  // Red and the background are the same in this channel, and what mixes them is, too.
  options_.background = {1.0f, 1.0f, 1.0f};
  for (const glm::u8vec4& pixel : presented()) ASSERT_EQ(pixel.r, 255);
}

TEST_P(ReductionTest, looks_up_points_at_pixels_of_the_full_size) {
  options_.reduction = 1;
  draw(frame_, camera_, kSize, options_);
  int asked = 0;
  const auto found_at = [&](glm::dvec2 pixel) { return renderer_->point_at(pixel); };
  glm::dvec2 middle(0.0);
  for (int y = 0; y < kSize.y; ++y)
    for (int x = 0; x < kSize.x; ++x) {
      const auto found = found_at({x + 0.5, y + 0.5});
      if (!found) continue;
      middle += glm::dvec2(x, y);
      ++asked;
    }
  ASSERT_GT(asked, 0);
  middle /= asked;
  options_.reduction = kReduction;
  draw(frame_, camera_, kSize, options_);
  const auto found = found_at(middle);
  ASSERT_TRUE(found);
  EXPECT_LT(glm::distance(*found, glm::dvec3(0.4, 0.25, 0.0)), 0.2);
}

}  // namespace
}  // namespace pointreel::reduction_test
