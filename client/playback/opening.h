#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/playback/stage.h"

namespace pointreel {

/// Opens a stage on a thread of its own, so that the window stays responsive meanwhile. To be used
/// by one thread.
class Opening {
 public:
  using Opened = Result<std::unique_ptr<Stage>>;

  /// As Stage::open. `options.on_ready` is called, too, when poll() or trouble() has something new.
  /// `camera_for` is called by the other thread, so it must be pure. Once the opening is destroyed,
  /// none of the functions given is called any more, unless the stage was taken.
  Opening(std::vector<Stage::Placed> sources, Stage::Options options, Stage::CameraFor camera_for,
          Stage::OnError on_error);
  /// Gives up, if the stage was not taken. Takes no longer than a tenth of a second: what does not
  /// end by then, such as the lookup of an unknown host, ends later by itself.
  ~Opening();
  Opening(const Opening&) = delete;
  Opening& operator=(const Opening&) = delete;

  /// The result, once, as soon as there is one.
  std::optional<Opened> poll();
  /// Why it takes so long, in one line, while a failure may pass.
  std::optional<std::string> trouble() const;

 private:
  struct Shared;
  const std::shared_ptr<Shared> shared_;
};

/// Whether something that was given up or retired has still not ended. A program that is to exit
/// now must not destroy what it may use.
bool unfinished();

/// Ends a stage that is not shown any more, in no longer than a tenth of a second: what takes
/// longer, such as decoding a large frame, ends later by itself. None of the stage's functions is
/// called any more.
void retire(std::unique_ptr<Stage> stage);

}  // namespace pointreel
