#include "client/ui/bindings.h"

#include <array>

#include <fmt/format.h>

namespace pointreel {
namespace {

/// Keys of the same action stand next to each other.
constexpr std::array kBindings = {
    Binding{"SPACE", Action::toggle_play, "play or pause"},
    Binding{"RIGHT", Action::seek_forward, "5 seconds forward"},
    Binding{"LEFT", Action::seek_back, "5 seconds back"},
    Binding{".", Action::step_forward, "one frame forward, and pause"},
    Binding{",", Action::step_back, "one frame back, and pause"},
    Binding{"[", Action::slower, "a tenth slower"},
    Binding{"]", Action::faster, "a tenth faster"},
    Binding{"BS", Action::normal_speed, "normal speed, forward"},
    Binding{"r", Action::turn_around, "backward, or forward again"},
    Binding{"l", Action::toggle_loop, "loop, or not"},
    Binding{"m", Action::next_mode, "surfels, voxels, points"},
    Binding{"n", Action::next_instancing, "the next way of instancing (--instancing)"},
    Binding{"b", Action::next_splatting, "the next way of splatting (--splatting)"},
    Binding{"0", Action::reset_view, "the first view again"},
    Binding{"f", Action::toggle_fullscreen, "full screen, or not"},
    Binding{"s", Action::screenshot, "write a picture into the current folder"},
    Binding{"i", Action::toggle_statistics, "statistics in the title"},
    Binding{"?", Action::help, "print these keys"},
    Binding{"q", Action::quit, "quit"},
    Binding{"ESC", Action::quit, "quit"},
};

}  // namespace

std::span<const Binding> bindings() { return kBindings; }

std::optional<Action> action_of(std::string_view key) {
  for (const Binding& binding : kBindings)
    if (binding.key == key) return binding.action;
  return std::nullopt;
}

std::string bindings_help() {
  std::string text;
  for (std::size_t i = 0; i < kBindings.size(); ++i) {
    std::string keys(kBindings[i].key);
    while (i + 1 < kBindings.size() && kBindings[i + 1].action == kBindings[i].action)
      keys += fmt::format(", {}", kBindings[++i].key);
    text += fmt::format("  {:<13} {}\n", keys, kBindings[i].help);
  }
  text +=
      "  left drag     orbit\n"
      "  right drag    move\n"
      "  wheel         nearer, farther\n"
      "  shift+drag    to any time: the window is as wide as the reel is long\n";
  return text;
}

}  // namespace pointreel
