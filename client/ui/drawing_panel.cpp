#include "client/ui/drawing_panel.h"

#include <algorithm>
#include <array>

#include <imgui.h>
#include <imgui_internal.h>

#include "client/ui/panel.h"

namespace pointreel {
namespace {

/// No numbers by keyboard: its keys are the player's.
constexpr ImGuiSliderFlags kByMouse = ImGuiSliderFlags_NoInput | ImGuiSliderFlags_AlwaysClamp;
constexpr float kTipSeconds = 0.5f;

struct Swatch {
  const char* tip;
  float gray;
};
constexpr std::array kBackgrounds = {Swatch{"Black", 0.0f}, Swatch{"Middle grey", 0.5f},
                                     Swatch{"White", 1.0f}};

void tip(const char* text) {
  if (ImGui::IsItemHovered() && !ImGui::IsItemActive() && GImGui->HoveredIdTimer > kTipSeconds)
    ImGui::SetTooltip("%s", text);
}

void heading(const char* text) {
  ImGui::Spacing();
  ImGui::TextDisabled("%s", text);
}

/// One of an enum's values, of which there are `count`.
template <class Enum>
bool choose(const char* label, Enum& value, int count) {
  bool changed = false;
  if (!ImGui::BeginCombo(label, name(value))) return false;
  for (int i = 0; i < count; ++i) {
    const Enum one = static_cast<Enum>(i);
    if (ImGui::Selectable(name(one), one == value) && one != value) {
      value = one;
      changed = true;
    }
  }
  ImGui::EndCombo();
  return changed;
}

/// The same beside each other, with labels that are short.
template <class Enum, std::size_t kCount>
bool choose_beside(Enum& value, const std::array<const char*, kCount>& labels) {
  bool changed = false;
  for (std::size_t i = 0; i < kCount; ++i) {
    const Enum one = static_cast<Enum>(i);
    if (i > 0) ImGui::SameLine();
    if (ImGui::RadioButton(labels[i], one == value) && one != value) {
      value = one;
      changed = true;
    }
  }
  return changed;
}

bool slide(const char* label, float& value, float least, float most, const char* format,
           ImGuiSliderFlags flags = 0) {
  return ImGui::SliderFloat(label, &value, least, most, format, kByMouse | flags);
}

bool surfel_settings(DrawOptions& draw) {
  bool changed = choose("Splatting", draw.splatting, kSplattings);
  tip("How discs become a picture: their weighted mean, or the paper's five ways");
  ImGui::BeginDisabled(draw.splatting != Splatting::normalized);
  changed |= slide("Visible size", draw.scales.visibility, 0.25f, 4.0f, "%.2f",
                   ImGuiSliderFlags_Logarithmic);
  tip("Of discs where they decide what is hidden");
  changed |=
      slide("Colour size", draw.scales.shading, 0.25f, 4.0f, "%.2f", ImGuiSliderFlags_Logarithmic);
  tip("Of discs where their colours are blended");
  changed |= ImGui::Checkbox("Fill holes", &draw.fill_holes);
  tip("Of closed surfaces, from what is around them");
  ImGui::EndDisabled();
  return changed;
}

bool voxel_settings(DrawSettings& settings) {
  auto delta = static_cast<float>(settings.delta);
  bool changed = slide("Delta", delta, 0.0f, 1.0f, "%.2f");
  tip("Share of points that may merge in voxels: less is finer, with gaps");
  if (changed) settings.delta = static_cast<double>(delta);
  changed |= ImGui::Checkbox("Fill holes", &settings.draw.fill_holes);
  tip("Gaps of up to three voxels, with voxels like those around");
  return changed;
}

bool element_settings(DrawSettings& settings) {
  DrawOptions& draw = settings.draw;
  bool changed = draw.mode == DrawMode::surfel ? surfel_settings(draw)
                 : draw.mode == DrawMode::voxel
                     ? voxel_settings(settings)
                     : slide("Point size", draw.point_size, 1.0f, 16.0f, "%.1f px");
  if (draw.mode != DrawMode::point) {
    changed |= choose("Instancing", draw.instancing, kInstancings);
    tip("How each element becomes triangles");
  }
  changed |= slide("Detail", draw.pixel_size, 0.0f, 16.0f, "%.1f px");
  tip("Below this size elements are drawn as one; 0: never");
  changed |= choose("Drafts", settings.drafts, kDrafts);
  tip("Fewer pixels where time is short: never, while a hand moves it, or while it plays, too");
  return changed;
}

bool light_settings(DrawOptions& draw) {
  bool changed = choose_beside(draw.color, std::array{"Colours", "Normals", "Plain"});
  changed |= ImGui::Checkbox("Lighting", &draw.lighting);
  tip("A light over the shoulder");
  changed |= slide("Eye-dome", draw.edl, 0.0f, 4.0f, "%.2f");
  tip("Darkens what lies behind what is beside it: shape without normals");
  return changed;
}

bool background_settings(DrawSettings& settings, const DrawOptions& defaults) {
  glm::vec3& color = settings.draw.background;
  const glm::vec3 before = color;
  constexpr ImGuiColorEditFlags kPlain =
      ImGuiColorEditFlags_NoTooltip | ImGuiColorEditFlags_NoDragDrop;
  const auto swatch = [&](const char* id, const glm::vec3& shown) {
    return ImGui::ColorButton(id, {shown.x, shown.y, shown.z, 1.0f}, kPlain);
  };
  if (swatch("##color", color)) ImGui::OpenPopup("pick");
  tip("Background: any colour");
  if (ImGui::BeginPopup("pick")) {
    ImGui::ColorPicker3("##picker", &color.x,
                        ImGuiColorEditFlags_NoInputs | ImGuiColorEditFlags_NoSidePreview |
                            ImGuiColorEditFlags_NoSmallPreview | ImGuiColorEditFlags_NoOptions);
    color = glm::clamp(color, 0.0f, 1.0f);
    ImGui::EndPopup();
  }
  ImGui::SameLine();
  ImGui::TextUnformatted("Background");
  ImGui::SameLine();
  if (swatch("##default", defaults.background)) color = defaults.background;
  tip("The usual one");
  for (const Swatch& one : kBackgrounds) {
    ImGui::SameLine();
    if (swatch(one.tip, glm::vec3(one.gray))) color = glm::vec3(one.gray);
    tip(one.tip);
  }
  const bool floor = ImGui::Checkbox("Floor grid", &settings.floor);
  return floor || color != before;
}

}  // namespace

bool drawing_panel(DrawSettings& settings, bool& open, glm::vec2 size, float scale) {
  // On the left, below the words that are said there: statistics are on the right.
  ImGui::SetNextWindowPos({12.0f * scale, std::min(48.0f * scale, 0.1f * size.y)},
                          ImGuiCond_FirstUseEver);
  bool changed = false;
  if (begin_panel("Drawing", open, ImGuiWindowFlags_NoFocusOnAppearing)) {
    ImGui::PushItemWidth(150.0f * scale);
    changed |= choose_beside(settings.draw.mode, std::array{"Surfels", "Voxels", "Points"});
    changed |= element_settings(settings);
    heading("Colour and light");
    changed |= light_settings(settings.draw);
    heading("Around it");
    const DrawSettings defaults;
    changed |= background_settings(settings, defaults.draw);
    ImGui::Spacing();
    if (ImGui::Button("Defaults")) {
      DrawSettings fresh = defaults;
      fresh.draw.mode = settings.draw.mode;
      changed |= settings != fresh;
      settings = fresh;
    }
    tip("All but surfels, voxels, points");
    ImGui::PopItemWidth();
  }
  ImGui::End();
  return changed;
}

}  // namespace pointreel
