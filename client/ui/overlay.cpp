#include "client/ui/overlay.h"

#include <algorithm>
#include <cmath>

#include <imgui.h>

#include "client/ui/bindings.h"

namespace pointreel {
namespace {

constexpr ImGuiWindowFlags kText =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_AlwaysAutoResize |
    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;

}  // namespace

void draw_said(const std::string& text, float scale) {
  ImGui::SetNextWindowPos(ImVec2(14.0f * scale, 14.0f * scale));
  ImGui::SetNextWindowBgAlpha(0.6f);
  ImGui::Begin("said", nullptr, kText);
  ImGui::TextUnformatted(text.c_str());
  ImGui::End();
}

void draw_waiting(const std::string& text, glm::vec2 size, float scale, double seconds) {
  ImGui::SetNextWindowPos(ImVec2(0.5f * size.x, 0.5f * size.y), ImGuiCond_Always,
                          ImVec2(0.5f, 0.5f));
  ImGui::SetNextWindowSizeConstraints(ImVec2(0.0f, 0.0f), ImVec2(0.9f * size.x, size.y));
  ImGui::SetNextWindowBgAlpha(0.6f);
  ImGui::Begin("waiting", nullptr, kText);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float r = 0.42f * ImGui::GetTextLineHeight();
  const auto turn = static_cast<float>(std::fmod(5.0 * seconds, 6.283));
  list.PathArcTo(ImVec2(at.x + r, at.y + 0.5f * ImGui::GetTextLineHeight()), r, turn, turn + 4.7f,
                 16);
  list.PathStroke(ImGui::GetColorU32(ImGuiCol_Text), 0, 2.0f * scale);
  ImGui::Dummy(ImVec2(2.0f * r, 0.0f));
  ImGui::SameLine();
  ImGui::TextUnformatted(text.c_str());
  ImGui::End();
}

void draw_error(const std::string& text, const std::string& hint, glm::vec2 size, float scale) {
  const float width = std::max(1.0f, size.x - 28.0f * scale);
  ImGui::SetNextWindowPos(ImVec2(14.0f * scale, 14.0f * scale));
  ImGui::SetNextWindowSizeConstraints(ImVec2(0.0f, 0.0f), ImVec2(width, size.y));
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.36f, 0.07f, 0.07f, 0.94f));
  ImGui::Begin("error", nullptr, kText);
  ImGui::PushTextWrapPos(width - 16.0f * scale);
  ImGui::TextUnformatted(text.c_str());
  if (!hint.empty()) {
    ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(1.0f, 1.0f, 1.0f, 0.7f));
    ImGui::TextUnformatted(hint.c_str());
    ImGui::PopStyleColor();
  }
  ImGui::PopTextWrapPos();
  ImGui::End();
  ImGui::PopStyleColor();
}

bool draw_help(glm::vec2 size, float scale) {
  bool open = true;
  ImGui::SetNextWindowPos(ImVec2(0.5f * size.x, 0.5f * size.y), ImGuiCond_Always,
                          ImVec2(0.5f, 0.5f));
  ImGui::SetNextWindowSizeConstraints(ImVec2(0.0f, 0.0f), ImVec2(0.96f * size.x, 0.96f * size.y));
  ImGui::Begin("Keys and mouse", &open,
               ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoNav);
  const std::span<const HelpLine> lines = help_lines();
  // In two columns where there is width for them.
  const bool wide = size.x > 760.0f * scale;
  const std::size_t columns = wide ? 2 : 1, rows = (lines.size() + columns - 1) / columns;
  if (ImGui::BeginTable("keys", static_cast<int>(2 * columns),
                        ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_RowBg)) {
    for (std::size_t row = 0; row < rows; ++row) {
      ImGui::TableNextRow();
      for (std::size_t i = row; i < lines.size(); i += rows) {
        ImGui::TableNextColumn();
        ImGui::TextColored(ImVec4(0.55f, 0.78f, 1.0f, 1.0f), "%s", lines[i].keys.c_str());
        ImGui::TableNextColumn();
        ImGui::Text("%.*s  ", static_cast<int>(lines[i].help.size()), lines[i].help.data());
      }
    }
    ImGui::EndTable();
  }
  ImGui::End();
  return open;
}

}  // namespace pointreel
