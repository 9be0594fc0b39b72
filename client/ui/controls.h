#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/options/settings.h"
#include "client/playback/clock.h"
#include "client/playback/stage.h"
#include "client/scene/camera.h"
#include "client/ui/bindings.h"
#include "client/ui/window_input.h"

namespace pointreel {

/// Acts on what plays, for keys, mouse and panels: its time, the camera and the settings. Knows
/// neither windows nor OpenGL; actions that need them are left to the caller of act().
class Controls {
 public:
  using Now = Clock::TimePoint;

  explicit Controls(const Settings& settings) : settings_(settings), given_up_(settings.up) {}

  /// Controls this stage from now on, and has its frames prepared as the settings say. The stage
  /// must live until the next call; null: nothing plays. `home` gives the view that reset_view
  /// comes back to, for the current bounds and size.
  void begin(Stage* stage, std::function<Camera()> home);

  /// False if the action is not for the controls, such as quit. Every other action has been done,
  /// or cannot be done while nothing plays.
  bool act(Action action, Now now);

  // Time. If there are several reels, the time is that of the first; dragging the timeline moves
  // all of them to the same fraction of their length.

  /// The first reel; null if there is none.
  const ReelPlayback* reel() const { return reel_; }
  /// The index of this reel on the stage.
  std::size_t source() const { return source_; }
  /// The frame of this reel that is shown; null if there is none.
  const SceneFrame* shown_frame() const {
    return reel_ ? stage_->scene()[source_].frame.get() : nullptr;
  }
  bool playing() const { return reel_ ? reel_->playing() : stage_ && stage_->playing(); }
  /// The start of an A-B loop whose end is not set yet.
  const std::optional<std::uint64_t>& loop_begin() const { return loop_a_; }
  void scrub_to(std::uint64_t time_us, Now now);
  void scrub_end(Now now);
  bool scrubbing() const { return reel_ && reel_->scrubbing(); }

  // Camera.

  const Camera& camera() const { return camera_; }
  /// Moves the camera as the mouse and the flying keys of `input` say, for a picture of `size`
  /// pixels and the `seconds` since the last call. True if it moved.
  bool move(const Input& input, glm::ivec2 size, double seconds);
  void center_on(const glm::dvec3& point);
  /// Frames the whole scene again, unless the user has moved the camera.
  void look_home_unless_moved();
  bool flying() const { return flying_; }
  /// Explains the keys that have another meaning just now; empty if none has.
  const char* unusual_keys() const {
    return flying_ ? "Flying: W A S D, E up, Q down, Shift faster; TAB or ESC ends it" : "";
  }

  // Settings and panels.

  const Settings& settings() const { return settings_; }
  void set_settings(const Settings& settings);
  bool show_help = false;

  /// A few words that tell the user what the last action did; given once.
  std::optional<std::string> take_said();

 private:
  bool act_on_settings(Action action);
  bool act_on_view(Action action);
  bool act_on_time(Action action, Now now);
  void seek_by(std::int64_t us, Now now);
  void set_speed(double speed, Now now);
  void mark_loop(Now now);
  void set_prepare_options();
  std::string time_text(Now now) const;

  Settings settings_;
  std::optional<Up> given_up_;  ///< by the user, for everything that plays
  Stage* stage_ = nullptr;
  ReelPlayback* reel_ = nullptr;  ///< the first reel of the stage
  std::size_t source_ = 0;
  std::function<Camera()> home_;
  Camera camera_;
  bool moved_ = false;  ///< the user has moved the camera
  bool flying_ = false;
  std::optional<std::uint64_t> loop_a_;
  std::optional<std::string> said_;
};

}  // namespace pointreel
