#pragma once

#include <cstdint>
#include <map>
#include <string>

#include <glm/glm.hpp>
#include <imgui.h>

#include "client/render/gl_objects.h"

namespace pointreel {

/// Panels of the gui as textures: a panel is drawn when something in it has changed, and copied
/// into the window for every picture. Panels are opaque and end at whole pixels. Needs the window's
/// OpenGL 4.5 context.
class PanelTextures {
 public:
  /// Where a panel is in its window's framebuffer, in pixels from the upper left corner.
  struct Place {
    glm::ivec2 corner{0}, size{1};
  };

  /// Copies the panel `name` into the window's framebuffer, which is `height` pixels high.
  /// `number` stands for what `list` holds. False where the driver has no texture for it.
  bool draw(const std::string& name, const ImDrawList& list, std::uint64_t number,
            const ImDrawData& all, const Place& place, int height);
  /// Those that were not drawn since the last call are gone.
  void forget_unused();

 private:
  struct Panel {
    gl::Texture texture;
    gl::Framebuffer framebuffer;
    glm::ivec2 size{0};
    std::uint64_t number = 0;
    bool used = false;
  };

  static bool make(Panel& panel, glm::ivec2 size);

  std::map<std::string, Panel> panels_;
};

}  // namespace pointreel
