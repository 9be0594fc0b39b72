#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "client/playback/reel_playback.h"
#include "pointreel/error.h"

namespace pointreel::bench {

/// Plays a reel over a link without a window: a picture counts as shown when its frame is ready to
/// draw. The camera is so near that all layers are needed.
class Watching {
 public:
  struct Options {
    DrawMode mode = DrawMode::surfel;
    bool keep_nothing = false;  ///< do not keep fetched frames for later seeks
  };
  static Result<std::unique_ptr<Watching>> start(const std::string& url, const Options& options);

  ReelPlayback& playback() { return *playback_; }
  /// Plays until `done` returns true; returns false if that takes longer than `timeout`.
  bool until(const std::function<bool(const ReelPlayback::Update&)>& done,
             std::chrono::milliseconds timeout = std::chrono::seconds(30));

 private:
  explicit Watching(std::unique_ptr<Source> source, const Options& options);
  std::unique_ptr<ReelPlayback> playback_;
};

}  // namespace pointreel::bench
