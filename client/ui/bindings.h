#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pointreel {

/// What a key or a button tells the player to do.
enum class Action {
  toggle_play,
  seek_forward,
  seek_back,
  seek_forward_little,
  seek_back_little,
  seek_forward_far,
  seek_back_far,
  seek_forward_tenth,
  seek_back_tenth,
  seek_start,
  seek_last,
  step_forward,
  step_back,
  slower,
  faster,
  half_speed,
  double_speed,
  normal_speed,
  turn_around,
  mark_loop,
  toggle_loop,
  tell_time,
  quieter,
  louder,
  toggle_mute,
  next_mode,
  next_instancing,
  next_splatting,
  toggle_floor,
  reset_view,
  // In the order of kNamedViews.
  view_front,
  view_back,
  view_left,
  view_right,
  view_top,
  view_bottom,
  turn_over,
  toggle_fly,
  add_camera_key,
  toggle_drawing,
  toggle_statistics,
  toggle_fullscreen,
  larger_interface,
  smaller_interface,
  screenshot,
  help,
  leave,
  quit,
};

/// A key is named by the character that it types, or else SPACE, LEFT, RIGHT, UP, DOWN, PGUP,
/// PGDWN, HOME, END, BACKSPACE, TAB, ESC, F1 or F11. Shift+LEFT and Shift+RIGHT are keys of their
/// own. But for BACKSPACE, the names are those of mpv, and so are the keys of every action that mpv
/// has too.
struct Binding {
  std::string_view key;
  Action action;
  std::string_view help;
};

/// The only table of keys. Neighbours with the same help share a line of it.
std::span<const Binding> bindings();

std::optional<Action> action_of(std::string_view key);

/// A line of the help: keys, or a gesture of the mouse, and what they do.
struct HelpLine {
  std::vector<std::string_view> keys;
  std::string_view help;
};
/// All lines, first the keys and then the mouse.
std::span<const HelpLine> help_lines();
/// The same as text.
std::string bindings_help();

}  // namespace pointreel
