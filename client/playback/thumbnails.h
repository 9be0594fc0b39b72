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

/// Coarse frames from anywhere in a reel, for small pictures of them: what is asked for is made by
/// a thread of its own that others go before, one at a time, the newest first, of the base layer
/// alone. The last ones are kept. For one thread.
class Thumbnails {
 public:
  /// What has been fetched of a frame already, if that does; by any thread.
  using Stored = std::function<std::optional<FetchedFrame>(std::uint32_t frame)>;

  static constexpr std::uint64_t kBytes = std::uint64_t{32} << 20;
  /// Finer than this none is made.
  static constexpr int kLevel = 7;

  /// `source` outlives it. Keeps no more than `bytes` of frames, but always the last one.
  /// `on_ready` is called by the thread when what get() was asked for is there, or cannot be had.
  Thumbnails(Source& source, Stored stored, std::uint64_t bytes = kBytes,
             std::function<void()> on_ready = {});
  /// Stops what is being fetched, and waits for the thread.
  ~Thumbnails();
  Thumbnails(const Thumbnails&) = delete;
  Thumbnails& operator=(const Thumbnails&) = delete;

  /// Null until it is there, or if it cannot be had; from when it is asked for it is on its way,
  /// unless many others are asked for after it. Its colours are for points.
  std::shared_ptr<const SceneFrame> get(std::uint32_t frame);

  /// While others wait for the link none is begun.
  void set_quiet(bool quiet);

  std::uint64_t bytes() const;

 private:
  struct Entry {
    std::shared_ptr<const SceneFrame> frame;  ///< null: it cannot be had
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
  mutable std::mutex mutex_;  ///< of what follows
  std::condition_variable changed_;
  std::vector<std::uint32_t> wanted_;  ///< the newest last
  std::optional<std::uint32_t> making_;
  std::map<std::uint32_t, Entry> entries_;
  std::uint64_t bytes_ = 0, uses_ = 0;
  bool quiet_ = false;
  std::thread thread_;  ///< from the first request on
};

}  // namespace pointreel
