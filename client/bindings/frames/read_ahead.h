#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <vector>

#include "client/bindings/frames/reel_frames.h"

namespace pointreel {

/// Reads frames in a given order, some of them before they are asked for: while the caller works
/// with one, threads of this object fetch and decode the next ones. No more than `ahead` frames are
/// held, so that memory does not grow. Threads that share it share the frames: each goes to one.
class ReadAhead {
 public:
  /// `ahead` is at least 1.
  ReadAhead(std::shared_ptr<const ReelFrames> reel, std::vector<std::uint32_t> order,
            const ReadLimits& limits, std::size_t ahead);
  /// Stops what is being read, and waits for it.
  ~ReadAhead();
  ReadAhead(const ReadAhead&) = delete;
  ReadAhead& operator=(const ReadAhead&) = delete;

  bool ended() const;
  /// The next frame, or why it cannot be had; nothing if it has not come by then, or if there are
  /// no more. Reading goes on with the frame after it where there is an error, too.
  std::optional<Result<SharedFrame>> next(std::chrono::milliseconds timeout);

 private:
  void end();
  void read();

  const std::shared_ptr<const ReelFrames> reel_;
  const std::vector<std::uint32_t> order_;
  ReadLimits limits_;
  const std::size_t ahead_;
  std::stop_source stop_;
  std::optional<std::stop_callback<std::function<void()>>> outer_stop_;  ///< stops stop_

  mutable std::mutex mutex_;  ///< guards what follows, up to the threads
  std::condition_variable changed_;
  std::map<std::size_t, Result<SharedFrame>> read_;  ///< by their place in the order
  std::size_t begun_ = 0, taken_ = 0;
  bool ending_ = false;

  std::vector<std::jthread> threads_;
};

}  // namespace pointreel
