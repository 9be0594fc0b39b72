#pragma once

#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "client/render/opengl/gl_context.h"
#include "client/render/opengl/gl_renderer.h"
#include "client/render/software/software_renderer.h"
#include "client/scene/renderer_choice.h"
#include "common/base/enum_names.h"
#include "common/threads/tbb_executor.h"

namespace pointreel {

/// A test that draws, with OpenGL or with the software renderer. It fails if there is no OpenGL
/// context: software OpenGL is a supported target, and shows the pictures of the other, too.
class DrawingTest : public testing::TestWithParam<RendererChoice> {
 protected:
  void SetUp() override {
    Result<OffscreenContext> context = OffscreenContext::create();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::make_unique<OffscreenContext>(std::move(*context));
    renderer_ = make_renderer();
  }
  void TearDown() override {
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    renderer_.reset();
  }

  std::unique_ptr<Renderer> make_renderer() const {
    if (GetParam() == RendererChoice::software)
      return std::make_unique<SoftwareRenderer>(tbb_executor());
    Result<GlRenderer> renderer = GlRenderer::create();
    EXPECT_TRUE(renderer) << renderer.error().message;
    return std::make_unique<GlRenderer>(std::move(*renderer));
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

inline std::string renderer_name(const testing::TestParamInfo<RendererChoice>& info) {
  return std::string(name(info.param));
}
inline const auto kBothRenderers =
    testing::Values(RendererChoice::opengl, RendererChoice::software);

}  // namespace pointreel
