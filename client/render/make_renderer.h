#pragma once

#include <memory>
#include <optional>

#include "client/render/opengl/gl_context.h"
#include "client/render/renderer.h"
#include "client/scene/renderer_choice.h"
#include "pointreel/error.h"

namespace pointreel {

/// A renderer whose pictures are shown in the window whose OpenGL context is current. `automatic`
/// takes OpenGL if a graphics card draws it.
Result<std::unique_ptr<Renderer>> make_window_renderer(RendererChoice choice);

/// A renderer that needs no window, with the OpenGL context that it draws with, if it does.
/// `automatic` takes OpenGL if there is one that a graphics card draws.
struct OffscreenRenderer {
  std::optional<OffscreenContext> context;
  std::unique_ptr<Renderer> renderer;
};
Result<OffscreenRenderer> make_offscreen_renderer(RendererChoice choice);

}  // namespace pointreel
