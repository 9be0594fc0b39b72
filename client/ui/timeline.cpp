#include "client/ui/timeline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <imgui.h>

#include "client/ui/panel.h"
#include "client/ui/time_text.h"

namespace pointreel {
namespace {

constexpr float kMargin = 14.0f, kTrackHeight = 6.0f, kButton = 26.0f;

ImU32 grey(float value, float alpha) {
  return ImGui::GetColorU32(ImVec4(value, value, value, alpha));
}
ImU32 accent(float alpha) { return ImGui::GetColorU32(ImVec4(0.30f, 0.62f, 0.98f, alpha)); }
ImU32 mark_color() { return ImGui::GetColorU32(ImVec4(0.98f, 0.75f, 0.25f, 1.0f)); }

enum class Icon {
  play,
  pause,
  step_back,
  step_forward,
  loop,
  help,
  drawing,
  statistics,
  fullscreen,
};

void draw_icon(ImDrawList& list, Icon icon, ImVec2 center, float r, ImU32 color) {
  const auto at = [&](float x, float y) { return ImVec2(center.x + x * r, center.y + y * r); };
  const auto box = [&](float x0, float y0, float x1, float y1) {
    list.AddRectFilled(at(x0, y0), at(x1, y1), color);
  };
  const float thick = std::max(1.0f, 0.22f * r);
  switch (icon) {
    case Icon::play:
      list.AddTriangleFilled(at(-0.7f, -0.9f), at(-0.7f, 0.9f), at(0.9f, 0.0f), color);
      break;
    case Icon::pause:
      box(-0.7f, -0.85f, -0.2f, 0.85f);
      box(0.2f, -0.85f, 0.7f, 0.85f);
      break;
    case Icon::step_back:
      list.AddTriangleFilled(at(0.7f, -0.8f), at(-0.4f, 0.0f), at(0.7f, 0.8f), color);
      box(-0.75f, -0.8f, -0.45f, 0.8f);
      break;
    case Icon::step_forward:
      list.AddTriangleFilled(at(-0.7f, -0.8f), at(-0.7f, 0.8f), at(0.4f, 0.0f), color);
      box(0.45f, -0.8f, 0.75f, 0.8f);
      break;
    case Icon::loop:
      list.PathArcTo(center, 0.8f * r, 0.6f, 5.6f, 20);
      list.PathStroke(color, 0, thick);
      list.AddTriangleFilled(at(0.95f, -0.95f), at(0.95f, -0.1f), at(0.15f, -0.35f), color);
      break;
    case Icon::help:
      list.PathArcTo(at(0.0f, -0.4f), 0.5f * r, 3.14f, 7.85f, 16);
      list.PathLineTo(at(0.0f, 0.45f));
      list.PathStroke(color, 0, thick);
      list.AddCircleFilled(at(0.0f, 0.85f), 0.18f * r, color, 8);
      break;
    case Icon::drawing:
      for (int row = 0; row < 3; ++row) {
        const float y = -0.65f + 0.65f * static_cast<float>(row);
        list.AddLine(at(-0.9f, y), at(0.9f, y), color, thick);
        list.AddCircleFilled(at(row == 1 ? 0.4f : -0.3f, y), 0.28f * r, color, 10);
      }
      break;
    case Icon::statistics:
      box(-0.85f, 0.1f, -0.4f, 0.85f);
      box(-0.2f, -0.45f, 0.25f, 0.85f);
      box(0.45f, -0.85f, 0.9f, 0.85f);
      break;
    case Icon::fullscreen:
      for (const float x : {-1.0f, 1.0f}) {
        for (const float y : {-1.0f, 1.0f}) {
          list.AddLine(at(0.85f * x, 0.85f * y), at(0.3f * x, 0.85f * y), color, thick);
          list.AddLine(at(0.85f * x, 0.85f * y), at(0.85f * x, 0.3f * y), color, thick);
        }
      }
      break;
  }
}

/// Draws a button of the bar at `corner`; true if the user has pressed it.
bool button(Icon icon, const char* id, ImVec2 corner, float edge, bool lit, const char* tip) {
  ImGui::SetCursorScreenPos(corner);
  const bool pressed = ImGui::InvisibleButton(id, ImVec2(edge, edge));
  const bool hovered = ImGui::IsItemHovered();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec2 end(corner.x + edge, corner.y + edge);
  if (hovered) list.AddRectFilled(corner, end, grey(1.0f, 0.12f), 4.0f);
  draw_icon(list, icon, ImVec2(corner.x + 0.5f * edge, corner.y + 0.5f * edge), 0.27f * edge,
            lit ? accent(1.0f) : grey(0.92f, 1.0f));
  if (hovered) ImGui::SetTooltip("%s", tip);
  return pressed;
}

/// The line on which the time is shown and dragged.
class Track {
 public:
  Track(const TimelineView& view, ImVec2 left, float width, float scale)
      : view_(view), left_(left), width_(width), scale_(scale) {}

  float x_of(std::uint64_t us) const {
    const double share = static_cast<double>(us) / static_cast<double>(view_.duration_us);
    return left_.x + width_ * static_cast<float>(std::min(1.0, share));
  }
  std::uint64_t time_at(float x) const {
    const double share = std::clamp((x - left_.x) / width_, 0.0f, 1.0f);
    return static_cast<std::uint64_t>(share * static_cast<double>(view_.duration_us));
  }

  void draw(bool hot) const {
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const float half = 0.5f * scale_ * kTrackHeight * (hot ? 1.4f : 1.0f);
    const auto bar = [&](float from, float to, ImU32 color) {
      list.AddRectFilled(ImVec2(from, left_.y - half), ImVec2(to, left_.y + half), color, half);
    };
    bar(left_.x, left_.x + width_, grey(0.75f, 0.22f));
    // Buffered frames: lighter with the base alone, darker with all layers.
    for (const TimelineView::Buffered& part : view_.buffered) {
      const float from = x_of(part.begin_us), to = std::max(x_of(part.end_us), from + 1.0f);
      const float value = 0.78f - 0.36f * part.share;
      list.AddRectFilled(ImVec2(from, left_.y - half), ImVec2(to, left_.y + half),
                         grey(value, 0.9f));
    }
    const float now = x_of(view_.position_us);
    list.AddRectFilled(ImVec2(left_.x, left_.y - 0.45f * half), ImVec2(now, left_.y + 0.45f * half),
                       accent(1.0f), half);
    if (view_.loop_a_us && view_.loop_b_us)
      list.AddRectFilled(ImVec2(x_of(*view_.loop_a_us), left_.y + 1.6f * half),
                         ImVec2(x_of(*view_.loop_b_us), left_.y + 2.2f * half), mark_color());
    if (view_.loop_a_us) draw_mark(list, x_of(*view_.loop_a_us), half, "A");
    if (view_.loop_b_us) draw_mark(list, x_of(*view_.loop_b_us), half, "B");
    list.AddCircleFilled(ImVec2(now, left_.y), (hot ? 2.0f : 1.6f) * half, grey(1.0f, 1.0f), 16);
  }

 private:
  void draw_mark(ImDrawList& list, float x, float half, const char* letter) const {
    list.AddLine(ImVec2(x, left_.y - 2.2f * half), ImVec2(x, left_.y + 2.2f * half), mark_color(),
                 2.0f * scale_);
    const ImVec2 size = ImGui::CalcTextSize(letter);
    list.AddText(ImVec2(x - 0.5f * size.x, left_.y - 2.4f * half - size.y), mark_color(), letter);
  }

  const TimelineView& view_;
  ImVec2 left_;  ///< the left end, at half the height
  float width_, scale_;
};

/// Shows the time under the cursor, and a picture of it if there is one.
void draw_hover(std::uint64_t time_us, const TimelineView& view, float x, float bottom,
                const std::optional<Thumbnail>& thumbnail, float width, float scale) {
  const std::string text =
      fmt::format("{}   frame {}", format_time(std::min(time_us, view.duration_us)),
                  view.timeline->shown_number(time_us));
  const ImVec2 words = ImGui::CalcTextSize(text.c_str());
  const float pad = 5.0f * scale;
  const float picture_x = thumbnail ? static_cast<float>(thumbnail->size.x) * scale : 0.0f;
  const float picture_y = thumbnail ? static_cast<float>(thumbnail->size.y) * scale : 0.0f;
  const ImVec2 size(std::max(words.x, picture_x) + 2.0f * pad, words.y + picture_y + 2.0f * pad);
  const ImVec2 corner(std::clamp(x - 0.5f * size.x, pad, std::max(pad, width - size.x - pad)),
                      bottom - size.y);
  ImDrawList& list = *ImGui::GetForegroundDrawList();
  list.AddRectFilled(corner, ImVec2(corner.x + size.x, corner.y + size.y),
                     ImGui::GetColorU32(ImVec4(0.05f, 0.055f, 0.065f, 0.92f)), 4.0f * scale);
  if (thumbnail) {
    const ImVec2 from(corner.x + 0.5f * (size.x - picture_x), corner.y + pad);
    // The first row of an OpenGL texture is the lowest.
    list.AddImage(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(thumbnail->texture)),
                  from, ImVec2(from.x + picture_x, from.y + picture_y), ImVec2(0.0f, 1.0f),
                  ImVec2(1.0f, 0.0f));
  }
  list.AddText(ImVec2(corner.x + 0.5f * (size.x - words.x), corner.y + pad + picture_y),
               grey(0.95f, 1.0f), text.c_str());
}

/// Lays out the bar from its upper left corner.
class Bar {
 public:
  Bar(const TimelineView& view, glm::vec2 size, float scale)
      : view_(view),
        size_(size),
        scale_(scale),
        margin_(kMargin * scale),
        top_(size.y - kTimelineHeight * scale),
        edge_(kButton * scale),
        x_(margin_ - 0.2f * edge_) {}

  void draw_track(const std::optional<Thumbnail>& thumbnail, bool dragged) {
    const TrackArea area = track_area(size_, scale_);
    const float width = area.right - area.left;
    const Track track(view_, ImVec2(margin_, top_ + 25.0f * scale_), width, scale_);
    const ImVec2 corner(area.left, area.top), end(area.right, area.bottom);
    const bool hovered =
        dragged || (ImGui::IsWindowHovered() && ImGui::IsMouseHoveringRect(corner, end));
    const float cursor = ImGui::GetIO().MousePos.x;
    track.draw(hovered);
    if (!hovered) return;
    use_.hovered_us = track.time_at(cursor);
    draw_hover(*use_.hovered_us, view_, std::clamp(cursor, margin_, margin_ + width),
               top_ - 4.0f * scale_, thumbnail, size_.x, scale_);
  }

  void draw_time_buttons() {
    if (!view_.live) next_button(Icon::step_back, Action::step_back, false, "one frame back  ,");
    next_button(view_.playing ? Icon::pause : Icon::play, Action::toggle_play, false,
                view_.playing ? "pause  SPACE" : "play  SPACE");
    if (view_.live) return;
    next_button(Icon::step_forward, Action::step_forward, false, "one frame forward  .");
    next_button(Icon::loop, Action::toggle_loop, view_.loop, "loop  L,  A-B loop  l");
  }

  /// Draws as much of the text as there is room for, the most important parts first.
  void draw_text() {
    std::vector<std::string> parts = {view_.playing ? "live" : "live, paused"};
    if (!view_.live) {
      parts = {format_time(view_.position_us), " / " + format_time(view_.duration_us),
               fmt::format("    frame {} / {}", view_.frame, view_.frames)};
      if (std::abs(view_.speed - 1.0) > 1e-3)
        parts.push_back(fmt::format("    {:.2f}x", view_.speed));
      if (view_.waiting) parts.push_back("    buffering");
    }
    const float left = x_ + 8.0f * scale_, room = window_buttons() - 4.0f * scale_ - left;
    std::string text;
    for (const std::string& part : parts) {
      if (ImGui::CalcTextSize((text + part).c_str()).x > room) break;
      text += part;
    }
    ImGui::GetWindowDrawList()->AddText(ImVec2(left, row() + 0.5f * (edge_ - ImGui::GetFontSize())),
                                        grey(0.92f, 1.0f), text.c_str());
  }

  void draw_window_buttons() {
    x_ = window_buttons();
    if (x_ < margin_ + 4.0f * edge_) return;
    next_button(Icon::help, Action::help, view_.help_shown, "keys and mouse  ?");
    next_button(Icon::drawing, Action::toggle_drawing, view_.drawing_shown, "drawing settings  d");
    next_button(Icon::statistics, Action::toggle_statistics, view_.statistics_shown,
                "statistics  i");
    next_button(Icon::fullscreen, Action::toggle_fullscreen, false, "full screen  f");
  }

  const TimelineUse& use() const { return use_; }

 private:
  float row() const { return top_ + 39.0f * scale_; }
  /// The left edge of the buttons on the right.
  float window_buttons() const { return size_.x - margin_ + 0.2f * edge_ - 4.0f * edge_; }

  void next_button(Icon icon, Action action, bool lit, const char* tip) {
    ImGui::PushID(static_cast<int>(action));
    if (button(icon, "button", ImVec2(x_, row()), edge_, lit, tip)) use_.action = action;
    ImGui::PopID();
    x_ += edge_;
  }

  const TimelineView& view_;
  const glm::vec2 size_;
  const float scale_, margin_, top_, edge_;
  float x_;  ///< where the next button goes
  TimelineUse use_;
};

}  // namespace

TrackArea track_area(glm::vec2 size, float scale) {
  // The line can be grabbed well above and below itself.
  const float margin = kMargin * scale, top = size.y - kTimelineHeight * scale;
  return {margin, std::max(margin + 1.0f, size.x - margin), top, top + 37.0f * scale};
}

TimelineUse draw_timeline(const TimelineView& view, const std::optional<Thumbnail>& thumbnail,
                          bool dragged, glm::vec2 size, float scale, float opacity) {
  const float height = kTimelineHeight * scale;
  ImGui::SetNextWindowPos(ImVec2(0.0f, size.y - height));
  ImGui::SetNextWindowSize(ImVec2(size.x, height));
  ImGui::PushStyleVar(ImGuiStyleVar_Alpha, opacity);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0.0f, 0.0f));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0.0f);
  ImGui::Begin(kTimelineWindow, nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
                   ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoNav |
                   (opacity < 1.0f ? 0 : kOnOpaqueGround));
  Bar bar(view, size, scale);
  if (!view.live) bar.draw_track(thumbnail, dragged);
  bar.draw_time_buttons();
  bar.draw_text();
  bar.draw_window_buttons();
  ImGui::End();
  ImGui::PopStyleVar(3);
  return bar.use();
}

}  // namespace pointreel
