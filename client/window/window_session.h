#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/options/play_options.h"
#include "client/playback/opening.h"
#include "client/playback/stage.h"
#include "client/sound/stage_audio.h"
#include "client/window/window_errors.h"

namespace pointreel {

/// What a window plays, and what it is opening in the background to play next. The options and the
/// errors must outlive it.
class WindowSession {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// Any thread calls `on_ready` when there is something new to be seen (Playback::OnReady).
  WindowSession(const PlayOptions& options, WindowErrors& errors, Playback::OnReady on_ready);
  /// Returns soon, even if it is still opening something.
  ~WindowSession();
  WindowSession(const WindowSession&) = delete;
  WindowSession& operator=(const WindowSession&) = delete;

  /// Begins to open sources, in place of others that are being opened, for pictures of `size`
  /// pixels.
  void open(std::vector<Stage::Placed> sources, const Settings& settings, glm::ivec2 size);
  bool opening() const { return opening_.has_value(); }
  void give_up_opening() { opening_.reset(); }
  /// What was opened, or why it could not be: once, as soon as that is known.
  std::optional<Opening::Opened> take_opened();

  /// Plays this from now on, and ends what was played before; null: nothing.
  void play(std::unique_ptr<Stage> stage);
  /// Lets the sound follow what the user or the stage did to time.
  void follow_time(const Settings& settings) {
    audio_.follow(settings.mute ? 0.0 : settings.volume / 100.0);
  }
  /// None if nothing that plays has sound.
  std::optional<AudioPlayer::Statistics> audio() const { return audio_.statistics(); }
  /// Null before the first stage has been opened.
  Stage* stage() const { return stage_.get(); }
  /// Whether there is a frame to be shown.
  bool has_frame() const;

  /// Names for people: of what was opened last, and of what plays.
  std::string opened_names() const;
  std::string playing_names() const;
  /// What the user waits for, and for how long; empty: nothing.
  std::string waiting() const;
  double waiting_seconds(TimePoint now) const;

 private:
  const PlayOptions& options_;
  WindowErrors& errors_;
  const Playback::OnReady on_ready_;
  std::vector<Stage::Placed> opened_;
  bool opened_any_ = false;
  TimePoint opening_since_{};
  std::unique_ptr<Stage> stage_;
  std::vector<std::string> playing_;  ///< how errors name what plays
  StageAudio audio_;
  std::optional<Opening> opening_;
};

/// The names of sources for people: the last parts of their paths or addresses.
std::string short_names(const std::vector<Stage::Placed>& sources);

}  // namespace pointreel
