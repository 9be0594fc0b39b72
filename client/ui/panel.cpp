#include "client/ui/panel.h"

#include <algorithm>

#include <imgui_internal.h>

namespace pointreel {

glm::vec2 natural_size(const char* title) {
  const ImGuiWindow* window = ImGui::FindWindowByName(title);
  if (!window) return glm::vec2(1.0f);
  // As ImGui finds it only when the panel is begun the next time.
  const ImGuiWindowTempData& built = window->DC;
  const ImVec2 pad = window->WindowPadding;
  return {
      std::max(built.CursorMaxPos.x, built.IdealMaxPos.x) - built.CursorStartPos.x + 2.0f * pad.x,
      std::max(built.CursorMaxPos.y, built.IdealMaxPos.y) - built.CursorStartPos.y + 2.0f * pad.y +
          window->TitleBarHeight()};
}

}  // namespace pointreel
