#include "client/ui/bindings.h"

#include <array>
#include <vector>

#include <fmt/format.h>

namespace pointreel {
namespace {

constexpr std::array kBindings = {
    Binding{"SPACE", Action::toggle_play, "play or pause"},
    Binding{"p", Action::toggle_play, "play or pause"},
    Binding{"LEFT", Action::seek_back, "5 seconds back, forward"},
    Binding{"RIGHT", Action::seek_forward, "5 seconds back, forward"},
    Binding{"Shift+LEFT", Action::seek_back_little, "1 second back, forward"},
    Binding{"Shift+RIGHT", Action::seek_forward_little, "1 second back, forward"},
    Binding{"DOWN", Action::seek_back_far, "1 minute back, forward"},
    Binding{"UP", Action::seek_forward_far, "1 minute back, forward"},
    Binding{"PGDWN", Action::seek_back_tenth, "a tenth of its length back, forward"},
    Binding{"PGUP", Action::seek_forward_tenth, "a tenth of its length back, forward"},
    Binding{"HOME", Action::seek_start, "to the beginning"},
    Binding{"END", Action::seek_last, "to the last frame, and pause"},
    Binding{",", Action::step_back, "one frame back, forward, and pause"},
    Binding{".", Action::step_forward, "one frame back, forward, and pause"},
    Binding{"[", Action::slower, "a tenth slower, faster"},
    Binding{"]", Action::faster, "a tenth slower, faster"},
    Binding{"{", Action::half_speed, "half, twice as fast"},
    Binding{"}", Action::double_speed, "half, twice as fast"},
    Binding{"BS", Action::normal_speed, "normal speed, forward"},
    Binding{"r", Action::turn_around, "backward, or forward again"},
    Binding{"l", Action::mark_loop, "A-B loop: set A, set B, clear"},
    Binding{"L", Action::toggle_loop, "loop the whole, or not"},
    Binding{"o", Action::tell_time, "what time it is, and which frame"},
    Binding{"m", Action::next_mode, "surfels, voxels, points"},
    Binding{"n", Action::next_instancing, "the next way of instancing"},
    Binding{"b", Action::next_splatting, "the next way of splatting"},
    Binding{"g", Action::toggle_floor, "a grid on the floor, or not"},
    Binding{"0", Action::reset_view, "the first view again"},
    Binding{"TAB", Action::toggle_fly, "fly with WASD, E up, Q down"},
    Binding{"k", Action::add_camera_key, "a key of a camera path, here and now"},
    Binding{"d", Action::toggle_drawing, "how it is drawn"},
    Binding{"i", Action::toggle_statistics, "statistics"},
    Binding{"f", Action::toggle_fullscreen, "full screen, or not"},
    Binding{"F11", Action::toggle_fullscreen, "full screen, or not"},
    Binding{"s", Action::screenshot, "write a picture into the current folder"},
    Binding{"?", Action::help, "this help, or not"},
    Binding{"F1", Action::help, "this help, or not"},
    Binding{"ESC", Action::leave, "leave help, flying, loading, full screen"},
    Binding{"q", Action::quit, "quit"},
};

std::vector<HelpLine> make_lines() {
  std::vector<HelpLine> lines;
  for (const Binding& binding : kBindings) {
    if (lines.empty() || lines.back().help != binding.help) lines.push_back({{}, binding.help});
    lines.back().keys.push_back(binding.key);
  }
  for (const auto& [mouse, help] : std::initializer_list<std::pair<const char*, const char*>>{
           {"left drag", "turn"},
           {"right drag", "move"},
           {"wheel", "nearer, farther: what is under the cursor"},
           {"double click", "turn about what is there"},
           {"shift+drag", "to any time, as if the window were the timeline"},
           {"wheel on the timeline", "one frame back, forward, and pause"},
           {"drop", "play a package, a folder or files"}})
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
    text += fmt::format("  {:<22} {}\n", fmt::format("{}", fmt::join(line.keys, "  ")), line.help);
  return text;
}

}  // namespace pointreel
