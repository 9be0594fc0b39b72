#include "client/ui/bindings.h"

#include <array>
#include <vector>

#include <fmt/format.h>

namespace pointreel {
namespace {

constexpr std::array kBindings = {
    Binding{"SPACE", Action::toggle_play, "play or pause"},
    Binding{"p", Action::toggle_play, "play or pause"},
    Binding{"LEFT", Action::seek_back, "go back or forward 5 seconds"},
    Binding{"RIGHT", Action::seek_forward, "go back or forward 5 seconds"},
    Binding{"Shift+LEFT", Action::seek_back_little, "go back or forward 1 second"},
    Binding{"Shift+RIGHT", Action::seek_forward_little, "go back or forward 1 second"},
    Binding{"DOWN", Action::seek_back_far, "go back or forward 1 minute"},
    Binding{"UP", Action::seek_forward_far, "go back or forward 1 minute"},
    Binding{"PGDWN", Action::seek_back_tenth, "go back or forward a tenth of the length"},
    Binding{"PGUP", Action::seek_forward_tenth, "go back or forward a tenth of the length"},
    Binding{"HOME", Action::seek_start, "go to the beginning"},
    Binding{"END", Action::seek_last, "go to the last frame and pause"},
    Binding{",", Action::step_back, "pause and step one frame back or forward"},
    Binding{".", Action::step_forward, "pause and step one frame back or forward"},
    Binding{"[", Action::slower, "play 10 % slower or faster"},
    Binding{"]", Action::faster, "play 10 % slower or faster"},
    Binding{"{", Action::half_speed, "play at half or twice the speed"},
    Binding{"}", Action::double_speed, "play at half or twice the speed"},
    Binding{"BACKSPACE", Action::normal_speed, "play forward at normal speed"},
    Binding{"r", Action::turn_around, "reverse the direction"},
    Binding{"l", Action::mark_loop, "A-B loop: set A, then B, then clear"},
    Binding{"L", Action::toggle_loop, "loop at the end, or stop there"},
    Binding{"o", Action::tell_time, "show the time and the frame number"},
    Binding{"/", Action::quieter, "quieter or louder"},
    Binding{"*", Action::louder, "quieter or louder"},
    Binding{"M", Action::toggle_mute, "sound off, or on again"},
    Binding{"m", Action::next_mode, "next mode: surfels, voxels, points, strips"},
    Binding{"n", Action::next_instancing, "next way of instancing"},
    Binding{"b", Action::next_splatting, "next way of splatting"},
    Binding{"g", Action::toggle_floor, "show or hide a grid on the floor"},
    Binding{"0", Action::reset_view, "return to the first view"},
    Binding{"1", Action::view_front, "look from the front, back, left, right, top, bottom"},
    Binding{"2", Action::view_back, "look from the front, back, left, right, top, bottom"},
    Binding{"3", Action::view_left, "look from the front, back, left, right, top, bottom"},
    Binding{"4", Action::view_right, "look from the front, back, left, right, top, bottom"},
    Binding{"5", Action::view_top, "look from the front, back, left, right, top, bottom"},
    Binding{"6", Action::view_bottom, "look from the front, back, left, right, top, bottom"},
    Binding{"u", Action::turn_over, "flip upside down"},
    Binding{"TAB", Action::toggle_fly, "fly: W A S D, E up, Q down"},
    Binding{"k", Action::add_camera_key, "add this view to a camera path"},
    Binding{"d", Action::toggle_drawing, "show or hide the drawing settings"},
    Binding{"i", Action::toggle_statistics, "show or hide the statistics"},
    Binding{"f", Action::toggle_fullscreen, "enter or leave full screen"},
    Binding{"F11", Action::toggle_fullscreen, "enter or leave full screen"},
    Binding{"+", Action::larger_interface, "larger or smaller interface"},
    Binding{"=", Action::larger_interface, "larger or smaller interface"},
    Binding{"-", Action::smaller_interface, "larger or smaller interface"},
    Binding{"s", Action::screenshot, "save a picture in the current folder"},
    Binding{"?", Action::help, "show or hide this help"},
    Binding{"F1", Action::help, "show or hide this help"},
    Binding{"ESC", Action::leave, "leave help, flying, loading or full screen"},
    Binding{"q", Action::quit, "quit"},
};

std::vector<HelpLine> make_lines() {
  std::vector<HelpLine> lines;
  for (const Binding& binding : kBindings) {
    if (lines.empty() || lines.back().help != binding.help) lines.push_back({{}, binding.help});
    lines.back().keys.push_back(binding.key);
  }
  for (const auto& [mouse, help] : std::initializer_list<std::pair<const char*, const char*>>{
           {"left drag", "turn the scene"},
           {"right drag", "move the scene"},
           {"wheel", "zoom in or out at the cursor"},
           {"double click", "turn the scene about this point"},
           {"shift+drag", "go to any time, as on the timeline"},
           {"wheel on the timeline", "pause and step one frame back or forward"},
           {"drop", "play the package, folder or files"}})
    lines.push_back({{mouse}, help});
  return lines;
}

}  // namespace

std::span<const Binding> bindings() { return kBindings; }

std::optional<Action> action_of(std::string_view key) {
  for (const Binding& binding : kBindings)
    if (binding.key == key) return binding.action;
  return std::nullopt;
}

std::span<const HelpLine> help_lines() {
  static const std::vector<HelpLine> lines = make_lines();
  return lines;
}

std::string bindings_help() {
  std::string text;
  for (const HelpLine& line : help_lines())
    text += fmt::format("  {:<23} {}\n", fmt::format("{}", fmt::join(line.keys, "  ")), line.help);
  return text;
}

}  // namespace pointreel
