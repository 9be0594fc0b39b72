#include "client/ui/statistics_panel.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <imgui.h>

#include "client/ui/panel.h"
#include "common/base/median.h"

namespace pointreel {
namespace {

const ImVec4 kLabel{0.55f, 0.78f, 1.0f, 1.0f};

void draw_lines(const std::vector<StatisticsLine>& lines) {
  if (!ImGui::BeginTable("figures", 2, ImGuiTableFlags_SizingFixedFit)) return;
  for (const StatisticsLine& line : lines) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextColored(kLabel, "%s", line.label.c_str());
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(line.text.c_str());
  }
  ImGui::EndTable();
}

/// Draws a plot of `size` for each step, from 0 to the longest time of the step.
void draw_plots(const RecentFrames& recent, ImVec2 size) {
  if (!ImGui::BeginTable("times", 3, ImGuiTableFlags_SizingFixedFit)) return;
  // Disabled plots do not show a value under the mouse, which would mean little by itself.
  ImGui::PushStyleVar(ImGuiStyleVar_DisabledAlpha, 1.0f);
  ImGui::BeginDisabled();
  for (const Step step : kSteps) {
    const std::vector<float> times = recent.times(step);
    const float most = *std::max_element(times.begin(), times.end());
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextColored(kLabel, "%s", name(step));
    ImGui::TableNextColumn();
    ImGui::PlotLines(fmt::format("##{}", name(step)).c_str(), times.data(),
                     static_cast<int>(times.size()), 0, nullptr, 0.0f, std::max(most, 0.01f), size);
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(fmt::format("{:.1f} ms, max. {:.1f}", median(times), most).c_str());
  }
  ImGui::EndDisabled();
  ImGui::PopStyleVar();
  ImGui::EndTable();
}

}  // namespace

bool draw_statistics(const std::vector<StatisticsLine>& lines, const RecentFrames& recent,
                     const PanelPlace& at, bool place, float scale) {
  bool open = true;
  set_next_panel(at, place, kStatisticsWidth * scale);
  begin_panel(kStatisticsPanel, open, ImGuiWindowFlags_NoFocusOnAppearing);
  draw_lines(lines);
  if (recent.size() > 0) {
    ImGui::Separator();
    // Plots are narrower if the window has no room for the numbers beside them.
    draw_plots(recent, ImVec2(std::clamp(at.most.x - 250.0f * scale, 20.0f * scale, 190.0f * scale),
                              26.0f * scale));
  }
  ImGui::End();
  return open;
}

}  // namespace pointreel
