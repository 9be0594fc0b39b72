#include "client/ui/overlay.h"

#include <algorithm>
#include <cmath>

#include <imgui.h>

#include "client/scene/scalar_colors.h"
#include "client/ui/bindings.h"
#include "client/ui/panel.h"

namespace pointreel {
namespace {

/// Begins a window for text of `size` at `corner`. ImGui itself would find the size one picture
/// late.
void begin_text(const char* id, ImVec2 corner, ImVec2 size) {
  const ImVec2 pad = ImGui::GetStyle().WindowPadding;
  ImGui::SetNextWindowPos(corner);
  ImGui::SetNextWindowSize(ImVec2(size.x + 2.0f * pad.x, size.y + 2.0f * pad.y));
  ImGui::Begin(id, nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
                   ImGuiWindowFlags_NoNav);
}

/// More does not fit a window, and ImGui cannot draw 16,384 letters at once.
constexpr std::size_t kMostText = 2000;

bool begins_character(char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }

/// Without the middle of texts, such as addresses, that are too long.
std::string shortened(const std::string& text) {
  if (text.size() <= kMostText) return text;
  std::size_t head = kMostText / 2, tail = text.size() - kMostText / 2;
  while (!begins_character(text[head])) --head;
  while (tail < text.size() && !begins_character(text[tail])) ++tail;
  return text.substr(0, head) + " ... " + text.substr(tail);
}

constexpr float kKeyPad = 5.0f, kKeyGap = 3.0f;

ImVec2 key_size(std::string_view key, float scale) {
  const ImVec2 words = ImGui::CalcTextSize(key.data(), key.data() + key.size());
  return {std::max(words.x + 2.0f * kKeyPad * scale, words.y), words.y};
}

/// Draws something that looks like a key, so that dots and commas stand out too.
void draw_key(std::string_view key, float scale) {
  const char *begin = key.data(), *end = begin + key.size();
  const ImVec2 words = ImGui::CalcTextSize(begin, end), corner = ImGui::GetCursorScreenPos();
  const float width = key_size(key, scale).x;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(corner, ImVec2(corner.x + width, corner.y + words.y),
                     ImGui::GetColorU32(ImVec4(0.22f, 0.25f, 0.30f, 1.0f)), 3.0f * scale);
  list.AddText(ImVec2(corner.x + 0.5f * (width - words.x), corner.y),
               ImGui::GetColorU32(ImVec4(0.75f, 0.88f, 1.0f, 1.0f)), begin, end);
  ImGui::Dummy(ImVec2(width, words.y));
}

/// The width of the keys of the widest line.
float keys_width(std::span<const HelpLine> lines, float scale) {
  float widest = 0.0f;
  for (const HelpLine& line : lines) {
    float width = -kKeyGap * scale;
    for (const std::string_view key : line.keys) width += kKeyGap * scale + key_size(key, scale).x;
    widest = std::max(widest, width);
  }
  return widest;
}

}  // namespace

void draw_said(const std::string& said, float scale) {
  const std::string text = shortened(said);
  ImGui::SetNextWindowBgAlpha(0.6f);
  begin_text("said", ImVec2(14.0f * scale, 14.0f * scale), ImGui::CalcTextSize(text.c_str()));
  ImGui::TextUnformatted(text.c_str());
  ImGui::End();
}

void draw_waiting(const std::string& what, glm::vec2 size, float scale, double seconds) {
  const std::string text = shortened(what);
  const float line = ImGui::GetTextLineHeight(), r = 0.42f * line;
  const ImVec2 words = ImGui::CalcTextSize(text.c_str());
  const float indent = 2.0f * r + ImGui::GetStyle().ItemSpacing.x;
  const ImVec2 all(indent + words.x, words.y);
  ImGui::SetNextWindowBgAlpha(0.6f);
  begin_text(
      "waiting",
      ImVec2(std::max(0.0f, 0.5f * (size.x - all.x)), std::max(0.0f, 0.5f * (size.y - all.y))),
      all);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const auto turn = static_cast<float>(std::fmod(5.0 * seconds, 6.283));
  list.PathArcTo(ImVec2(at.x + r, at.y + 0.5f * line), r, turn, turn + 4.7f, 16);
  list.PathStroke(ImGui::GetColorU32(ImGuiCol_Text), 0, 2.0f * scale);
  ImGui::SetCursorScreenPos(ImVec2(at.x + indent, at.y));
  ImGui::TextUnformatted(text.c_str());
  ImGui::End();
}

void draw_legend(const Legend& legend, glm::vec2 corner, float scale) {
  const float line = ImGui::GetTextLineHeight(), gap = 4.0f * scale, bar = 0.7f * line;
  const auto width_of = [](const std::string& text) { return ImGui::CalcTextSize(text.c_str()).x; };
  const float ends = width_of(legend.least) + width_of(legend.most) + 20.0f * scale;
  const bool ramp = legend.labels.empty();
  const float width =
      std::max({width_of(legend.title), ramp ? ends : 0.0f, ramp ? 160.0f * scale : 0.0f});
  const float body = ramp ? bar + gap + line : static_cast<float>(legend.labels.size()) * line;
  const ImVec2 pad = ImGui::GetStyle().WindowPadding;
  const ImVec2 size(width, line + gap + body);
  ImGui::SetNextWindowBgAlpha(0.6f);
  begin_text("legend",
             ImVec2(corner.x + 14.0f * scale, corner.y - 14.0f * scale - size.y - 2.0f * pad.y),
             size);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const ImU32 ink = ImGui::GetColorU32(ImGuiCol_Text);
  const auto color_of = [](const glm::u8vec3& c) { return IM_COL32(c.r, c.g, c.b, 255); };
  list.AddText(at, ink, legend.title.c_str());
  float y = at.y + line + gap;
  if (ramp) {
    constexpr int kParts = 20;
    for (int i = 0; i < kParts; ++i) {
      const float left = at.x + width * static_cast<float>(i) / kParts;
      const float right = at.x + width * static_cast<float>(i + 1) / kParts;
      const ImU32 from = color_of(ramp_color(i / double{kParts}));
      const ImU32 to = color_of(ramp_color((i + 1) / double{kParts}));
      list.AddRectFilledMultiColor(ImVec2(left, y), ImVec2(right, y + bar), from, to, to, from);
    }
    y += bar + gap;
    list.AddText(ImVec2(at.x, y), ink, legend.least.c_str());
    list.AddText(ImVec2(at.x + width - width_of(legend.most), y), ink, legend.most.c_str());
  }
  for (const auto& [color, label] : legend.labels) {
    list.AddRectFilled(ImVec2(at.x, y + 0.15f * line), ImVec2(at.x + bar, y + 0.15f * line + bar),
                       color_of(color));
    list.AddText(ImVec2(at.x + bar + gap, y), ink, label.c_str());
    y += line;
  }
  ImGui::Dummy(size);
  ImGui::End();
}

float draw_error(const std::string& text, const std::string& hint, glm::vec2 size, float scale) {
  const float width = std::max(1.0f, size.x - 44.0f * scale);
  const std::string all = shortened(text) + (hint.empty() ? "" : "\n" + hint);
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.36f, 0.07f, 0.07f, 0.94f));
  begin_text("error", ImVec2(14.0f * scale, 14.0f * scale),
             ImGui::CalcTextSize(all.c_str(), nullptr, false, width));
  ImGui::PushTextWrapPos(width + ImGui::GetStyle().WindowPadding.x);
  ImGui::TextUnformatted(all.c_str());
  ImGui::PopTextWrapPos();
  const float bottom = ImGui::GetWindowPos().y + ImGui::GetWindowSize().y;
  ImGui::End();
  ImGui::PopStyleColor();
  return bottom + 8.0f * scale;
}

HelpUse draw_help(glm::vec2 size, float scale, int lines_down) {
  HelpUse use;
  const std::span<const HelpLine> lines = help_lines();
  // In two columns if the window is wide enough, otherwise in one whose lines wrap.
  const bool wide = size.x > 760.0f * scale;
  const std::size_t columns = wide ? 2 : 1, rows = (lines.size() + columns - 1) / columns;
  const ImVec2 most(0.96f * size.x, 0.96f * size.y);
  const float width = std::min(most.x, 460.0f * scale);
  ImGui::SetNextWindowPos(ImVec2(0.5f * size.x, 0.5f * size.y), ImGuiCond_Always,
                          ImVec2(0.5f, 0.5f));
  ImGui::SetNextWindowSizeConstraints(ImVec2(wide ? 0.0f : width, 0.0f),
                                      ImVec2(wide ? most.x : width, most.y));
  begin_panel("Keys and mouse", use.open, ImGuiWindowFlags_NoMove);
  if (ImGui::BeginTable("keys", static_cast<int>(2 * columns),
                        ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_RowBg)) {
    if (!wide) {
      const ImGuiStyle& style = ImGui::GetStyle();
      const float keys = keys_width(lines, scale);
      ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed, keys);
      ImGui::TableSetupColumn("help", ImGuiTableColumnFlags_WidthFixed,
                              width - keys - 2.0f * style.WindowPadding.x - style.ScrollbarSize -
                                  4.0f * style.CellPadding.x);
    }
    for (std::size_t row = 0; row < rows; ++row) {
      ImGui::TableNextRow();
      for (std::size_t i = row; i < lines.size(); i += rows) {
        ImGui::TableNextColumn();
        for (std::size_t k = 0; k < lines[i].keys.size(); ++k) {
          if (k > 0) ImGui::SameLine(0.0f, kKeyGap * scale);
          draw_key(lines[i].keys[k], scale);
        }
        ImGui::TableNextColumn();
        ImGui::PushTextWrapPos(wide ? -1.0f : 0.0f);
        ImGui::Text("%.*s  ", static_cast<int>(lines[i].help.size()), lines[i].help.data());
        ImGui::PopTextWrapPos();
      }
    }
    ImGui::EndTable();
  }
  use.scrolls = ImGui::GetScrollMaxY() > 0.0f;
  const float from = ImGui::IsWindowAppearing() ? 0.0f : ImGui::GetScrollY();
  ImGui::SetScrollY(from + static_cast<float>(lines_down) * ImGui::GetTextLineHeightWithSpacing());
  ImGui::End();
  return use;
}

}  // namespace pointreel
