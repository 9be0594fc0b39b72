#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace pointreel {

/// What a key makes the player do.
enum class Action {
  toggle_play,
  seek_forward,
  seek_back,
  step_forward,
  step_back,
  slower,
  faster,
  normal_speed,
  turn_around,
  toggle_loop,
  next_mode,
  next_instancing,
  next_splatting,
  toggle_fullscreen,
  screenshot,
  toggle_statistics,
  reset_view,
  help,
  quit,
};

/// A key is named by the character that it types, or else SPACE, LEFT, RIGHT, BS, ESC: mpv's names,
/// and mpv's keys wherever it has the action.
struct Binding {
  std::string_view key;
  Action action;
  std::string_view help;
};

/// The only table of keys: what they do, and what the help says.
std::span<const Binding> bindings();

std::optional<Action> action_of(std::string_view key);

/// The bindings, one line an action, and the mouse.
std::string bindings_help();

}  // namespace pointreel
