#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "client/source/fetched.h"
#include "codec/live/live.h"

namespace pointreel {

/// The newest frame of a live stream, as far as it has come.
struct LiveFrame {
  std::uint32_t number = 0;
  std::uint64_t capture_us = 0;   ///< Unix time of the publisher's clock, microseconds
  FetchedFrame frame;             ///< its first layers, at least the base
  std::uint32_t layers_sent = 1;  ///< how many layers the publisher made of it
};

/// What has happened so far.
struct LiveCounts {
  std::uint64_t frames = 0;         ///< distinct frames that next() gave
  std::uint64_t skipped = 0;        ///< frames that came but were overtaken by a newer one
  std::uint64_t dropped = 0;        ///< layers that the server says it left out for this viewer
  std::uint64_t bad = 0;            ///< messages that do not belong to this stream
  std::uint64_t reconnections = 0;  ///< connections made after the first
  std::uint64_t bytes = 0;          ///< of layers
};

/// Assembles the layers of a live stream into frames. It holds no more than two frames: one that is
/// coming and one that has come. It never looks at a clock of its own: each call passes the time
/// (`now`, which must not decrease).
///
/// A frame is given when all its layers have come, when the next frame begins, or with fewer layers
/// when the rest does not come for a while; if the rest comes after all before the next frame, the
/// frame is given again with more layers. Older frames are skipped. A publisher that was started
/// again begins at any number.
///
/// Trust: layers may be hostile. A layer that does not fit those before it is counted as bad and
/// left out.
class LiveFrames {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// A frame that has had no new layer for `patience` is given as it is.
  explicit LiveFrames(TimePoint::duration patience = std::chrono::milliseconds(15))
      : patience_(patience) {}

  void add(LiveHello hello);
  /// `bytes`: those that `layer.bytes` views. They are kept, not copied.
  void add(const LiveLayer& layer, SharedBytes bytes, TimePoint now);
  /// A message that was neither.
  void add_bad() { ++counts_.bad; }
  /// How many layers the server has left out on this connection.
  void set_dropped(std::uint64_t layers) { counts_.dropped = dropped_before_ + layers; }
  /// What follows comes over a new connection. It begins with a hello and the base of any frame.
  void reconnected();

  /// What the publisher says of its stream; none if it has said nothing yet.
  const std::optional<LiveHello>& hello() const { return hello_; }
  /// A frame newer than the last one given, or the same with more layers.
  std::optional<LiveFrame> next(TimePoint now);
  /// When `next` gives a frame although nothing comes; none if it does not.
  std::optional<TimePoint> due() const;
  const LiveCounts& counts() const { return counts_; }

 private:
  bool newer(std::uint32_t number) const { return !newest_ || number > *newest_; }
  void keep_coming();

  TimePoint::duration patience_;
  std::optional<LiveHello> hello_;
  std::optional<LiveFrame> coming_;  ///< layers of it are still missing
  TimePoint newest_layer_{};
  std::optional<LiveFrame> come_;        ///< waits to be given
  std::optional<std::uint32_t> newest_;  ///< the frame whose base came last
  std::optional<std::uint32_t> given_;   ///< the frame that was given last
  std::size_t given_layers_ = 0;         ///< how many layers that frame had
  LiveCounts counts_;
  std::uint64_t dropped_before_ = 0;  ///< on earlier connections
};

}  // namespace pointreel
