#include "client/ui/drawing_panel.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <variant>

#include <imgui.h>
#include <imgui_internal.h>

#include "client/options/option_table.h"
#include "client/ui/panel.h"

namespace pointreel {
namespace {

/// Sliders take no numbers from the keyboard, whose keys are the player's.
constexpr ImGuiSliderFlags kByMouse = ImGuiSliderFlags_NoInput | ImGuiSliderFlags_AlwaysClamp;
constexpr float kTipSeconds = 0.5f;

struct Swatch {
  const char* tip;
  float gray;
};
constexpr std::array kBackgrounds = {Swatch{"Black", 0.0f}, Swatch{"Middle grey", 0.5f},
                                     Swatch{"White", 1.0f}};

void show_tip(const char* text) {
  if (text != nullptr && ImGui::IsItemHovered() && !ImGui::IsItemActive() &&
      GImGui->HoveredIdTimer > kTipSeconds)
    ImGui::SetTooltip("%s", text);
}

void heading(const char* text) {
  ImGui::Spacing();
  ImGui::TextDisabled("%s", text);
}

// Widgets for the options of the table. A value that the user does not touch stays as it is, even
// if it is outside of what a slider shows.

void edit_value(const Option& option, const Option::Flag& flag, Settings& settings) {
  bool value = flag.get(settings);
  if (ImGui::Checkbox(option.label, &value)) flag.set(settings, value);
}

void edit_value(const Option& option, const Option::Number& number, Settings& settings) {
  auto value = static_cast<float>(number.get(settings));
  if (ImGui::SliderFloat(option.label, &value, static_cast<float>(number.slider.min),
                         static_cast<float>(number.slider.max), number.format,
                         kByMouse | (number.logarithmic ? ImGuiSliderFlags_Logarithmic : 0)))
    number.set(settings, static_cast<double>(value));
}

void edit_value(const Option& option, const Option::Choice& choice, Settings& settings) {
  const std::size_t chosen = choice.get(settings);
  if (!choice.labels.empty()) {
    for (std::size_t i = 0; i < choice.labels.size(); ++i) {
      if (i > 0) ImGui::SameLine();
      if (ImGui::RadioButton(choice.labels[i], i == chosen)) choice.set(settings, i);
    }
  } else if (ImGui::BeginCombo(option.label, choice.names[chosen])) {
    for (std::size_t i = 0; i < choice.names.size(); ++i)
      if (ImGui::Selectable(choice.names[i], i == chosen)) choice.set(settings, i);
    ImGui::EndCombo();
  }
}

void edit_value(const Option& option, const Option::Color& option_color, Settings& settings) {
  const glm::vec3 before = option_color.get(settings), usual = option_color.get({});
  glm::vec3 color = before;
  const auto swatch = [](const char* id, const glm::vec3& shown) {
    return ImGui::ColorButton(id, {shown.x, shown.y, shown.z, 1.0f},
                              ImGuiColorEditFlags_NoTooltip | ImGuiColorEditFlags_NoDragDrop);
  };
  if (swatch("##color", color)) ImGui::OpenPopup("pick");
  show_tip("Choose any colour");
  if (ImGui::BeginPopup("pick")) {
    ImGui::ColorPicker3("##picker", &color.x,
                        ImGuiColorEditFlags_NoInputs | ImGuiColorEditFlags_NoSidePreview |
                            ImGuiColorEditFlags_NoSmallPreview | ImGuiColorEditFlags_NoOptions);
    color = glm::clamp(color, 0.0f, 1.0f);
    ImGui::EndPopup();
  }
  ImGui::SameLine();
  ImGui::TextUnformatted(option.label);
  ImGui::SameLine();
  if (swatch("##default", usual)) color = usual;
  show_tip("Default");
  for (const Swatch& background : kBackgrounds) {
    ImGui::SameLine();
    if (swatch(background.tip, glm::vec3(background.gray))) color = glm::vec3(background.gray);
    show_tip(background.tip);
  }
  if (color != before) option_color.set(settings, color);
}

/// Sizes are not in the panel: the user drags the frame of the window.
void edit_value(const Option&, const Option::Size&, Settings&) {}

void edit(const char* name, Settings& settings) {
  const Option& option = find_option(name);
  std::visit([&](const auto& value) { edit_value(option, value, settings); }, option.value);
  show_tip(option.tip);
}

/// The option "color", to whose names those of scalar fields are added.
void edit_color(Settings& settings, std::span<const std::string> fields) {
  const Option& option = find_option("color");
  const auto& choice = std::get<Option::Choice>(option.value);
  std::string& field = settings.scalar.field;
  const bool shows_field = settings.draw.color == ColorSource::colors && !field.empty();
  const char* const shown = shows_field ? field.c_str() : choice.names[choice.get(settings)];
  if (ImGui::BeginCombo(option.label, shown)) {
    for (std::size_t i = 0; i < choice.names.size(); ++i) {
      if (!ImGui::Selectable(choice.names[i], !shows_field && i == choice.get(settings))) continue;
      choice.set(settings, i);
      settings.scalar = {};
    }
    for (const std::string& name : fields) {
      ImGui::PushID(name.c_str());
      if (ImGui::Selectable(name.c_str(), shows_field && name == field)) {
        settings.draw.color = ColorSource::colors;
        if (name != field) settings.scalar = {name, std::nullopt};
      }
      ImGui::PopID();
    }
    ImGui::EndCombo();
  }
  show_tip(option.tip);
}

void edit_surfels(Settings& settings) {
  edit("splatting", settings);
  ImGui::BeginDisabled(settings.draw.splatting != Splatting::normalized);
  edit("visibility_scale", settings);
  edit("shading_scale", settings);
  edit("fill_holes", settings);
  ImGui::EndDisabled();
  edit("refine", settings);
}

void edit_elements(Settings& settings) {
  switch (settings.draw.mode) {
    case DrawMode::surfel:
      edit_surfels(settings);
      break;
    case DrawMode::voxel:
      edit("voxel_merge", settings);
      edit("fill_holes", settings);
      break;
    case DrawMode::point:
      edit("point_size", settings);
      edit("adaptive_points", settings);
      break;
    case DrawMode::strip:
      edit("fill_holes", settings);
      break;
  }
  edit("renderer", settings);
  if (settings.draw.mode == DrawMode::surfel || settings.draw.mode == DrawMode::voxel)
    edit("instancing", settings);
  edit("smooth_outlines", settings);
  edit("pixel_size", settings);
  edit("drafts", settings);
}

/// Sets everything about drawing that the panel can show to its default, except the mode. Sound
/// that was turned down stays so.
void restore_defaults(Settings& settings) {
  for (const Option& option : option_table())
    if (option.label != nullptr && option.name != "mode" && option.group == "Drawing")
      copy_value(option, {}, settings);
  settings.scalar = {};
}

}  // namespace

bool drawing_panel(Settings& settings, std::span<const std::string> fields, const PanelPlace& at,
                   bool place, float scale) {
  set_next_panel(at, place);
  const Settings before = settings;
  if (begin_panel(kDrawingPanel, settings.drawing_panel, ImGuiWindowFlags_NoFocusOnAppearing)) {
    ImGui::PushItemWidth(150.0f * scale);
    edit("mode", settings);
    edit_elements(settings);
    heading("Colour and light");
    edit_color(settings, fields);
    edit("light", settings);
    if (settings.draw.light == Light::flat)
      edit("lighting", settings);
    else
      edit("roughness", settings);
    edit("edl", settings);
    heading("Surroundings");
    edit("background", settings);
    edit("floor", settings);
    heading("Sound");
    edit("volume", settings);
    edit("mute", settings);
    ImGui::Spacing();
    if (ImGui::Button("Defaults")) restore_defaults(settings);
    show_tip("Resets everything but the mode and the sound");
    ImGui::PopItemWidth();
  }
  ImGui::End();
  return settings != before;
}

}  // namespace pointreel
