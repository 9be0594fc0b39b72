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

/// A hash of what a frame was decoded to: its voxels and their colours.
std::uint64_t content_of(const SceneFrame& frame);

/// The valid contents of each frame of a reel: one for each number of layers.
using Truth = std::map<std::uint32_t, std::set<std::uint64_t>>;

/// The truth of a package in a folder, as point mode shows it from near.
Result<Truth> truth_of(const std::string& folder);

/// Plays in a thread as a player does, with a hundred updates per second, and records what it saw.
class Watcher {
 public:
  using Clock = std::chrono::steady_clock;

  struct Shown {
    Clock::time_point at;
    std::uint32_t frame = 0;
    std::uint32_t layers = 0;
    bool right = false;  ///< its content is in the truth
  };

  /// Plays the package at `url` in a loop. `truth` must outlive the watcher.
  Watcher(std::string url, const Truth& truth);
  ~Watcher();
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;

  /// All frames shown so far. A frame counts once for as long as it stayed.
  std::vector<Shown> shown() const;
  /// The number of updates without a picture although there had been one before.
  std::uint64_t blank() const;
  std::optional<std::string> trouble() const;  ///< also if the package cannot be opened
  std::uint64_t errors() const;

  // Each waits for at most two minutes and returns false if it did not happen.

  /// Waits until this many more frames have been shown.
  bool sees(std::size_t more);
  /// Waits until nothing new has been shown for this time.
  bool stands_still(std::chrono::milliseconds time);
  bool hears_of_trouble();
  bool hears_of_no_trouble();
  /// Whether there was trouble at any time, however short.
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
