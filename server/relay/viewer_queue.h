#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>

#include "common/stream/live.h"
#include "pointreel/bytes.h"

namespace pointreel {

/// One message of a live stream. All viewers share its bytes.
struct LiveMessage {
  enum class Kind : std::uint8_t { text, binary };
  Kind kind = Kind::binary;
  std::shared_ptr<const Bytes> bytes;
};

LiveMessage text_message(std::string_view text);

struct ViewerLimits {
  std::size_t frames = 4;         ///< that may wait, the newest included; at least 1
  std::size_t bytes = 16u << 20;  ///< that may wait, the newest base not counted
};

/// What waits for one viewer: a value without locks or a clock.
///
/// A viewer that takes messages as they come gets all of them. Once more frames wait than the
/// limits allow it is behind, and what waits of frames before the newest goes, for it would only be
/// seen late; and from then on it gets a layer less of each frame, until it has kept up for a
/// while. That while doubles each time that a layer more proves too much. So a viewer whose link
/// does not carry everything gets coarser frames, then fewer of them, and always the newest base.
class ViewerQueue {
 public:
  explicit ViewerQueue(const ViewerLimits& limits = {}) : limits_(limits) {}

  /// Tells of the stream; takes the place of what waited to be told so. With a new session, frames
  /// of the one before go.
  void hello(LiveMessage text, bool new_session);
  /// Tells, after all that waits, that the publisher has gone.
  void end(LiveMessage text);

  /// Layers as LiveLayer says: frames in order, base first, none missing below one that comes.
  void push(std::uint32_t frame, std::uint8_t layer, std::uint8_t layers, LiveMessage message);

  /// What to send next; nothing if nothing waits. Counts of drops come as messages, too.
  std::optional<LiveMessage> next();

  bool empty() const { return !hello_ && !end_ && drops_ == told_ && bytes_ == 0; }
  /// Bytes of layers that wait.
  std::size_t bytes() const { return bytes_; }
  const LiveDrops& drops() const { return drops_; }
  /// Layers of each frame that the viewer gets now, if there are so many.
  int layers() const { return cap_; }

 private:
  struct Frame {
    std::uint32_t number = 0;
    std::uint8_t first = 0;  ///< layer that `messages` begins with
    std::uint8_t next = 0;   ///< layer that comes next
    bool cut = false;        ///< a layer was dropped: finer ones are of no use
    std::deque<LiveMessage> messages;
  };
  void begin_frame(std::uint32_t number, std::uint8_t layers);
  void drop_finest(Frame& frame);
  void drop_before_newest();
  void fall_behind(std::uint8_t layers);

  static constexpr int kMostLayers = 8;
  static constexpr int kFirstPatience = 8, kMostPatience = 512;  ///< frames

  ViewerLimits limits_;
  std::optional<LiveMessage> hello_, end_;
  std::deque<Frame> frames_;  ///< oldest first; the newest stays when it is taken
  std::size_t bytes_ = 0;
  LiveDrops drops_, told_;
  int cap_ = kMostLayers;
  int calm_ = 0, patience_ = kFirstPatience, since_raise_ = kMostPatience;
};

}  // namespace pointreel
