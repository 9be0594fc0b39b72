#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "client/playback/playback.h"
#include "client/scene/frame.h"
#include "pointreel/error.h"

namespace pointreel {

/// What a frame was decoded to: its voxels and their colours.
std::uint64_t content_of(const SceneFrame& frame);

/// What each frame of a reel may look like: once for each number of its layers.
using Truth = std::map<std::uint32_t, std::set<std::uint64_t>>;

/// Truth of a package in a folder, as point mode shows it from near.
Result<Truth> truth_of(const std::string& folder);

/// Plays in a thread as a player does, a hundred looks a second, and keeps what it saw.
class Watcher {
 public:
  using Clock = std::chrono::steady_clock;

  struct Shown {
    Clock::time_point at;
    std::uint32_t frame = 0;
    std::uint32_t layers = 0;
    bool right = false;  ///< what it looks like is in the truth
  };

  /// Plays the package at `url` in a loop. `truth` outlives the watcher.
  Watcher(std::string url, const Truth& truth);
  ~Watcher();
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;

  /// All that was shown so far, each frame once as long as it stayed.
  std::vector<Shown> shown() const;
  /// Looks at which there was no picture, although there had been one.
  std::uint64_t blank() const;
  std::optional<std::string> trouble() const;  ///< also that the package cannot be opened
  std::uint64_t errors() const;

  // Each waits for at most two minutes; false if it did not happen.

  /// So many more frames are shown than are now.
  bool sees(std::size_t more);
  /// Nothing new is shown for so long a time.
  bool stands_still(std::chrono::milliseconds time);
  bool hears_of_trouble();
  bool hears_of_no_trouble();
  /// There was trouble at any time, however soon it had passed.
  bool heard_of_trouble();

 private:
  void play(const std::string& url);
  bool wait(const std::function<bool()>& condition);

  const Truth& truth_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool ending_ = false;
  std::vector<Shown> shown_;
  std::uint64_t blank_ = 0, errors_ = 0;
  std::optional<std::string> trouble_;
  bool heard_of_trouble_ = false;
  std::thread thread_;
};

}  // namespace pointreel
