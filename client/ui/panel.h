#pragma once

#include <imgui.h>

namespace pointreel {

/// Marks an ImGui window that Gui draws on an opaque background and keeps as a texture.
inline constexpr ImGuiWindowFlags kOnOpaqueGround = ImGuiWindowFlags_NoBackground;

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
