#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <vector>

#include "client/scene/frame.h"
#include "client/source/source.h"

namespace pointreel {

/// Coarse frames from anywhere in a reel, for small pictures. A thread of low priority makes those
/// that are requested, one at a time, the newest request first, from the base layer alone. The ones
/// used last are kept. To be used by one thread.
class Thumbnails {
 public:
  /// The base of a frame if it has been fetched already. Called by any thread.
  using Stored = std::function<std::optional<FetchedFrame>(std::uint32_t frame)>;

  static constexpr std::uint64_t kBytes = std::uint64_t{32} << 20;
  /// The finest level that a thumbnail has.
  static constexpr int kLevel = 7;

  /// `source` outlives it. Keeps no more than `bytes` of frames, but always the last one. The
  /// thread calls `on_ready` when a frame that was requested is there, or failed.
  Thumbnails(Source& source, Stored stored, std::uint64_t bytes = kBytes,
             std::function<void()> on_ready = {});
  /// Stops fetching, and waits for the thread.
  ~Thumbnails();
  Thumbnails(const Thumbnails&) = delete;
  Thumbnails& operator=(const Thumbnails&) = delete;

  /// Null until the frame is there, or if it cannot be had. The first call requests it, which
  /// lapses if many others are requested after it. The frame is prepared to be drawn as points.
  std::shared_ptr<const SceneFrame> get(std::uint32_t frame);

  /// While quiet, none is begun, so that playback has the link to itself.
  void set_quiet(bool quiet);

  std::uint64_t bytes() const;

 private:
  struct Entry {
    std::shared_ptr<const SceneFrame> frame;  ///< null: it failed
    std::uint64_t bytes = 0, used = 0;
  };

  void run();
  Result<SceneFrame> make(std::uint32_t frame);
  void keep(std::uint32_t frame, std::shared_ptr<const SceneFrame> made);

  Source& source_;
  const Stored stored_;
  const std::uint64_t budget_;
  const std::function<void()> on_ready_;
  std::stop_source stop_;
  mutable std::mutex mutex_;  ///< guards what follows
  std::condition_variable changed_;
  std::vector<std::uint32_t> wanted_;  ///< the newest last
  std::optional<std::uint32_t> making_;
  std::map<std::uint32_t, Entry> entries_;
  std::uint64_t bytes_ = 0, uses_ = 0;
  bool quiet_ = false;
  std::thread thread_;  ///< started by the first request
};

}  // namespace pointreel
