#pragma once

#include <imgui.h>

namespace pointreel {

/// A window of the gui that Gui draws on opaque ground and keeps as a texture.
inline constexpr ImGuiWindowFlags kOnOpaqueGround = ImGuiWindowFlags_NoBackground;

/// ImGui::Begin of a panel with a title, which `open` becomes false by; rectangular, because it is
/// opaque. ImGui::End follows.
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
