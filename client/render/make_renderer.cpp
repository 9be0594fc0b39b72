#include "client/render/make_renderer.h"

#include <utility>

#include "client/render/opengl/gl_renderer.h"
#include "client/render/software/software_renderer.h"
#include "common/base/try.h"
#include "common/threads/tbb_executor.h"

namespace pointreel {
namespace {

std::unique_ptr<Renderer> make_software_renderer() {
  return std::make_unique<SoftwareRenderer>(tbb_executor());
}

Result<std::unique_ptr<Renderer>> make_gl_renderer() {
  return std::make_unique<GlRenderer>(TRY(GlRenderer::create()));
}

}  // namespace

Result<std::unique_ptr<Renderer>> make_window_renderer(RendererChoice choice) {
  const bool software = choice == RendererChoice::software ||
                        (choice == RendererChoice::automatic && is_software_opengl());
  if (software) return make_software_renderer();
  return make_gl_renderer();
}

Result<OffscreenRenderer> make_offscreen_renderer(RendererChoice choice) {
  OffscreenRenderer made;
  if (choice != RendererChoice::software) {
    Result<OffscreenContext> context = OffscreenContext::create();
    const bool usable = context && (choice == RendererChoice::opengl || !is_software_opengl());
    if (usable) {
      made.context = *std::move(context);
      made.renderer = TRY(make_gl_renderer());
      return made;
    }
    if (choice == RendererChoice::opengl)
      return fail(context.error().code,
                  context.error().message + "; --renderer software draws without OpenGL");
  }
  made.renderer = make_software_renderer();
  return made;
}

}  // namespace pointreel
