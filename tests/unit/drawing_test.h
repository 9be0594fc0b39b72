#pragma once

#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "client/render/opengl/gl_context.h"
#include "client/render/opengl/gl_renderer.h"

namespace pointreel {

/// A test that draws. It fails if there is no OpenGL context: software OpenGL is a supported
/// target.
class DrawingTest : public testing::Test {
 protected:
  void SetUp() override {
    Result<OffscreenContext> context = OffscreenContext::create();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::make_unique<OffscreenContext>(std::move(*context));
    Result<GlRenderer> renderer = GlRenderer::create();
    ASSERT_TRUE(renderer) << renderer.error().message;
    renderer_ = std::make_unique<GlRenderer>(std::move(*renderer));
  }
  void TearDown() override {
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    renderer_.reset();
  }

  Image draw(const std::shared_ptr<const SceneFrame>& frame, const Camera& camera, glm::ivec2 size,
             const DrawOptions& options) {
    return draw(Scene{{frame}}, camera, size, options);
  }

  Image draw(const Scene& scene, const Camera& camera, glm::ivec2 size,
             const DrawOptions& options) {
    const Result<DrawStats> stats = renderer_->draw(scene, camera, size, options);
    EXPECT_TRUE(stats) << stats.error().message;
    if (stats) stats_ = *stats;
    Result<Image> image = renderer_->read_pixels();
    EXPECT_TRUE(image);
    return image ? std::move(*image) : Image{};
  }

  std::unique_ptr<OffscreenContext> context_;
  std::unique_ptr<Renderer> renderer_;
  DrawStats stats_;  ///< of the last picture
};

}  // namespace pointreel
