#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/playback/stage.h"

namespace pointreel {

/// A stage that is being opened by a thread of its own, so that nobody stands still meanwhile. For
/// one thread.
class Opening {
 public:
  using Opened = Result<std::unique_ptr<Stage>>;

  /// As Stage::open. `options.on_ready` is called, too, when poll() or trouble() has something new.
  /// `camera_for` is called by the other thread, so it must be pure. Once the opening is destroyed,
  /// none of the functions given is called any more, unless the stage was taken.
  Opening(std::vector<Stage::Placed> sources, Stage::Options options, Stage::CameraFor camera_for,
          Stage::OnError on_error);
  /// Gives it up, if the stage was not taken. Takes no longer than a blink of an eye: what does not
  /// end by then, as a host's name that nobody knows, ends later by itself.
  ~Opening();
  Opening(const Opening&) = delete;
  Opening& operator=(const Opening&) = delete;

  /// What came of it: once, as soon as it is there.
  std::optional<Opened> poll();
  /// Why that takes its time, in one line, if something is wrong that may pass.
  std::optional<std::string> trouble() const;

 private:
  struct Shared;
  const std::shared_ptr<Shared> shared_;
};

/// Ends a stage that nobody looks at any more, in no longer than a blink of an eye: what it waits
/// for longer than that, as a large frame that is being decoded, ends later by itself. Its OnError
/// is not called any more.
void retire(std::unique_ptr<Stage> stage);

}  // namespace pointreel
