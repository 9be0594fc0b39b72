#pragma once

#include <glm/glm.hpp>
#include <imgui.h>

#include "client/ui/panel_layout.h"

namespace pointreel {

/// Marks an ImGui window that Gui draws on an opaque background and keeps as a texture.
inline constexpr ImGuiWindowFlags kOnOpaqueGround = ImGuiWindowFlags_NoBackground;

inline constexpr const char *kDrawingPanel = "Drawing", *kStatisticsPanel = "Statistics";

/// The size that the panel of this title needs to show everything, as it was built last; some size
/// if it has not been built yet.
glm::vec2 natural_size(const char* title);

/// Puts the panel that is begun next there if `place`, and limits its size. It is at least as wide
/// as `least_width`, if it has room for that.
inline void set_next_panel(const PanelPlace& at, bool place, float least_width = 0.0f) {
  if (place) ImGui::SetNextWindowPos(ImVec2(at.corner.x, at.corner.y));
  ImGui::SetNextWindowSizeConstraints(ImVec2(glm::min(least_width, at.most.x), 0.0f),
                                      ImVec2(at.most.x, at.most.y));
}

/// ImGui::Begin for a panel with a title bar, whose close button clears `open`. It has square
/// corners, because it is opaque. The caller calls ImGui::End.
inline bool begin_panel(const char* title, bool& open, ImGuiWindowFlags flags = 0) {
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0.0f);
  const bool shown = ImGui::Begin(title, &open,
                                  flags | kOnOpaqueGround | ImGuiWindowFlags_AlwaysAutoResize |
                                      ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
                                      ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav);
  ImGui::PopStyleVar();
  return shown;
}

}  // namespace pointreel
