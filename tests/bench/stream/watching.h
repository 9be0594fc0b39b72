#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "client/playback/reel_playback.h"
#include "pointreel/error.h"

namespace pointreel::bench {

/// Somebody who plays a reel over a link, without a screen: a picture is there when its frame is
/// ready to draw. Everything is wanted of it, as by a camera that is near.
class Watching {
 public:
  struct Options {
    DrawMode mode = DrawMode::surfel;
    bool keep_nothing = false;  ///< nothing that was fetched is still there when it is gone back to
  };
  static Result<std::unique_ptr<Watching>> start(const std::string& url, const Options& options);

  ReelPlayback& playback() { return *playback_; }
  /// Plays until `done` says so; false if `timeout` passes before.
  bool until(const std::function<bool(const ReelPlayback::Update&)>& done,
             std::chrono::milliseconds timeout = std::chrono::seconds(30));

 private:
  explicit Watching(std::unique_ptr<Source> source, const Options& options);
  std::unique_ptr<ReelPlayback> playback_;
};

}  // namespace pointreel::bench
