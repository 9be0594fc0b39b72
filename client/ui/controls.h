#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/playback/clock.h"
#include "client/playback/stage.h"
#include "client/prepare/prepare.h"
#include "client/scene/camera.h"
#include "client/scene/draw_options.h"
#include "client/ui/bindings.h"
#include "client/ui/window_input.h"

namespace pointreel {

/// How things are drawn, as far as the user can choose it while they play.
struct DrawSettings {
  DrawOptions draw;
  double delta = PrepareOptions{}.delta;
  bool floor = false;  ///< a grid on the floor
  Drafts drafts = Drafts::playing;

  bool operator==(const DrawSettings&) const = default;
};

/// What the user has chosen, and what keys, mouse and widgets do to it and to what plays. Knows
/// neither window nor OpenGL: what needs those is left to the caller of act().
class Controls {
 public:
  using Now = Clock::TimePoint;

  explicit Controls(const DrawSettings& settings) : settings_(settings) {}

  /// From now on this plays, and its frames are prepared as the settings say. It outlives the
  /// controls or is followed by another; null: nothing plays. `home`: the view that reset_view
  /// comes back to, for the bounds and the size of now.
  void begin(Stage* stage, std::function<Camera()> home);

  /// False: an action that is not for the controls, such as quit. Anything else has been done, or
  /// cannot be done while nothing plays.
  bool act(Action action, Now now);

  // Time. Of several reels, the first one's is told, and all go to the same share of their length.

  /// Null where nothing plays that has a time.
  const ReelPlayback* reel() const { return reel_; }
  bool playing() const { return reel_ ? reel_->playing() : stage_ && stage_->playing(); }
  /// A of an A-B loop whose B is not set yet.
  const std::optional<std::uint64_t>& loop_begin() const { return loop_a_; }
  void scrub_to(std::uint64_t time_us, Now now);
  void scrub_end(Now now);
  bool scrubbing() const { return reel_ && reel_->scrubbing(); }

  // Camera.

  const Camera& camera() const { return camera_; }
  /// The mouse and the flying of `input`, in a picture of `size` pixels, in the `seconds` since the
  /// last call. True if the camera moved.
  bool move(const Input& input, glm::ivec2 size, double seconds);
  void center_on(const glm::dvec3& point);
  /// Looks at everything anew, unless the user has chosen where to look from.
  void look_home_unless_moved();
  bool flying() const { return flying_; }
  /// What keys do that do something else otherwise; empty if none does.
  const char* unusual_keys() const {
    return flying_ ? "Flying: W A S D, E up, Q down, shift faster; TAB or ESC ends it" : "";
  }

  // Drawing.

  const DrawSettings& settings() const { return settings_; }
  void set_settings(const DrawSettings& settings);
  bool show_drawing = false, show_statistics = false, show_help = false;

  /// What to tell the user of the last action, in a few words; given once.
  std::optional<std::string> take_said();

 private:
  bool act_on_time(Action action, Now now);
  void seek_by(std::int64_t us, Now now);
  void set_speed(double speed, Now now);
  void mark_loop(Now now);
  void set_prepare_options();
  std::string time_text(Now now) const;

  DrawSettings settings_;
  Stage* stage_ = nullptr;
  ReelPlayback* reel_ = nullptr;  ///< the first one's
  std::function<Camera()> home_;
  Camera camera_;
  bool moved_ = false;  ///< the user has chosen where to look from
  bool flying_ = false;
  std::optional<std::uint64_t> loop_a_;
  std::optional<std::string> said_;
};

}  // namespace pointreel
