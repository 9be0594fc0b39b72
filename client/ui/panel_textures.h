#pragma once

#include <cstdint>
#include <map>
#include <string>

#include <glm/glm.hpp>
#include <imgui.h>

#include "client/render/opengl/gl_objects.h"

namespace pointreel {

/// Keeps panels of the interface as textures: a panel is drawn when something in it has changed,
/// and copied into the window for every picture. Panels are opaque and end at whole pixels. Needs
/// the window's OpenGL 4.5 context.
class PanelTextures {
 public:
  /// The position of a panel in the window's framebuffer, in pixels from the upper left corner.
  struct Place {
    glm::ivec2 corner{0}, size{1};
  };

  /// Copies the panel `name` into the window's framebuffer, which is `height` pixels high. `number`
  /// is a checksum of `list`. False if the driver cannot make a texture for the panel.
  bool draw(const std::string& name, const ImDrawList& list, std::uint64_t number,
            const ImDrawData& all, const Place& place, int height);
  /// Forgets the panels that were not drawn since the last call.
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
