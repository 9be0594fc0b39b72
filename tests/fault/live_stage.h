#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/source/live_source.h"
#include "pointreel/codec.h"

namespace pointreel {

/// The frames of a live stream, which repeat, and the content to which each decodes.
class LiveReel {
 public:
  static const LiveReel& get();  ///< made once for all tests
  const EncodedFrame& frame(std::uint32_t number) const { return frames_[number % frames_.size()]; }
  /// The capture time encodes which of the frames it is.
  std::uint64_t capture_us(std::uint64_t now_us, std::uint32_t number) const {
    return now_us - now_us % 1000 + number % frames_.size();
  }
  /// Whether the layers of that frame decode to this. Returns nothing if they do not decode.
  std::optional<bool> is_right(const LiveFrame& frame) const;

 private:
  LiveReel();
  std::vector<EncodedFrame> frames_;
  std::vector<std::vector<std::uint64_t>> truth_;  ///< by frame and by number of layers
};

/// Publishes LiveReel at 30 frames per second and reconnects with the same session. Each publisher
/// has a session of its own.
class StagePublisher {
 public:
  explicit StagePublisher(std::string url);
  ~StagePublisher();
  StagePublisher(const StagePublisher&) = delete;
  StagePublisher& operator=(const StagePublisher&) = delete;
  std::uint64_t newest_us() const { return newest_us_; }  ///< the capture time of the newest frame

 private:
  void run();
  const std::string url_;
  std::atomic<bool> ending_{false};
  std::atomic<std::uint64_t> newest_us_{0};
  std::thread thread_;
};

/// Takes every frame that a live source gives, and records what it saw.
class LiveWatcher {
 public:
  struct Shown {
    std::chrono::steady_clock::time_point at;
    std::uint32_t frame = 0;
    std::uint64_t capture_us = 0;
    std::uint32_t layers = 0;
    bool right = false;
  };

  /// `url` must be that of a live source.
  explicit LiveWatcher(const std::string& url);
  ~LiveWatcher();
  LiveWatcher(const LiveWatcher&) = delete;
  LiveWatcher& operator=(const LiveWatcher&) = delete;

  std::vector<Shown> shown() const;
  std::uint64_t undecodable() const;
  std::optional<std::string> trouble() const { return source_->trouble(); }
  LiveCounts counts() const { return source_->counts(); }

  // Each waits for at most two minutes and returns false if it did not happen.

  bool sees(std::size_t more);
  bool sees_what_is_as_new_as(std::uint64_t capture_us);
  bool hears_of_trouble(bool there = true);
  bool connects_again();

 private:
  void watch();

  std::unique_ptr<LiveSource> source_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Shown> shown_;
  std::uint64_t undecodable_ = 0;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace pointreel
