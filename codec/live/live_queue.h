#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string_view>

#include "codec/live/live.h"
#include "common/base/backoff.h"
#include "pointreel/bytes.h"
#include "pointreel/chunks.h"

namespace pointreel {

/// One message of a live stream. Copies share its bytes.
struct LiveMessage {
  enum class Kind : std::uint8_t { text, binary };
  Kind kind = Kind::binary;
  /// The whole message; or, if there are `chunks`, only the header of a layer.
  std::shared_ptr<const Bytes> bytes;
  /// The chunks of a layer as the encoder made them. They are sent without being joined first.
  std::shared_ptr<const Chunks<Bytes>> chunks = nullptr;

  std::size_t size() const;
  /// The message consists of these pieces in this order; some may be empty.
  std::array<ByteView, 4> pieces() const;
};

LiveMessage text_message(std::string_view text);

/// A message from a header (`layer`, whose `sizes` and `bytes` are ignored) and the layer's chunks.
LiveMessage layer_message(LiveLayer layer, Chunks<Bytes> chunks);

struct LiveQueueOptions {
  std::size_t frames = 4;         ///< frames that may wait, including the newest; at least 1
  std::size_t bytes = 16u << 20;  ///< bytes that may wait, not counting the newest base layer
  bool tell_drops = true;         ///< send the receiver a message about what it did not get
};

/// The messages that wait to be sent over one link: a value without locks and without a clock.
///
/// A receiver that takes messages as they come gets all of them. If more frames wait than the
/// options allow, the receiver is behind: everything before the newest frame is dropped, because it
/// would arrive late, and from then on the receiver gets one layer fewer of each frame until it has
/// kept up for some time. That time doubles whenever an additional layer turns out to be too much.
/// A receiver behind a slow link therefore gets coarser frames, then fewer frames, and always the
/// newest base layer.
class LiveQueue {
 public:
  explicit LiveQueue(const LiveQueueOptions& options = {}) : options_(options) {}

  /// Queues a hello, in place of one that still waits. A new session also drops all frames of the
  /// session before.
  void hello(LiveMessage text, bool new_session);
  /// Queues, behind everything that waits, the message that the publisher has gone.
  void end(LiveMessage text);

  /// Queues a layer. Layers come as LiveLayer describes: frames in order, the base first, and no
  /// layer missing below one that comes.
  void push(std::uint32_t frame, std::uint8_t layer, std::uint8_t layers, LiveMessage message);

  /// Queues a packet of sound, which goes before all layers. Of those that wait, the newest second
  /// is kept.
  void sound(LiveMessage message);

  /// The message to send next, which may be one about drops; nothing if nothing waits.
  std::optional<LiveMessage> next();

  bool empty() const {
    return !hello_ && !end_ && !drops_untold() && bytes_ == 0 && sounds_.empty();
  }
  /// Bytes of all layers that wait.
  std::size_t bytes() const { return bytes_; }
  const LiveDrops& drops() const { return drops_; }

 private:
  struct Frame {
    std::uint32_t number = 0;
    std::uint8_t first = 0;  ///< the layer with which `messages` begins
    std::uint8_t next = 0;   ///< the layer that is expected next
    bool cut = false;        ///< a layer was dropped, which makes finer ones useless
    std::deque<LiveMessage> messages;
  };
  void begin_frame(std::uint32_t number, std::uint8_t layers);
  void drop_finest(Frame& frame);
  void drop_before_newest();
  void fall_behind(std::uint8_t layers);
  bool drops_untold() const { return options_.tell_drops && drops_ != told_; }

  static constexpr int kAllLayers = 255;
  static constexpr int kMaxPatience = 512;  ///< frames

  LiveQueueOptions options_;
  static constexpr std::size_t kMaxSounds = 50;  ///< of 20 ms

  std::optional<LiveMessage> hello_, end_;
  std::deque<LiveMessage> sounds_;
  std::deque<Frame> frames_;  ///< oldest first; the newest stays after its messages were taken
  std::size_t bytes_ = 0;
  LiveDrops drops_, told_;
  int max_layers_ = kAllLayers;  ///< layers of each frame that the receiver gets at present
  /// For how many frames the receiver must keep up before it gets an additional layer.
  Backoff<int> patience_{8, kMaxPatience};
  /// For how many frames it has kept up, and how many have come since it got the last layer.
  int calm_ = 0, since_raise_ = kMaxPatience;
};

}  // namespace pointreel
