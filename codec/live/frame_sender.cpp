#include "codec/live/frame_sender.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "codec/core/scalar_fields.h"
#include "codec/live/live_queue.h"
#include "codec/live/live_sound.h"
#include "common/base/try.h"
#include "common/net/url.h"
#include "common/net/websocket.h"

namespace pointreel {
namespace {

/// How long sending the last frames may take at the end; the longer time over a link that works.
constexpr std::chrono::milliseconds kFlushTime{2000}, kSlowFlushTime{8000};

/// The messages of an encoded frame, one for each layer.
std::vector<LiveMessage> messages_of(EncodedFrame encoded, std::uint32_t number,
                                     std::uint64_t capture_us) {
  LiveLayer header;
  header.frame = number;
  header.layers = static_cast<std::uint8_t>(encoded.layers.size());
  header.capture_us = capture_us;
  header.points = encoded.source_points;
  std::vector<LiveMessage> messages;
  for (Chunks<Bytes>& layer : encoded.layers) {
    messages.push_back(layer_message(header, std::move(layer)));
    ++header.layer;
  }
  return messages;
}

}  // namespace

FrameSender::FrameSender(OutboxOptions options, const ReelHead& head, LiveIdentity identity)
    : identity_(identity), outbox_(std::move(options)) {
  static_cast<ReelHead&>(hello_) = head;
}

void FrameSender::send(EncodedFrame frame, const Content& content, std::uint64_t capture_us) {
  greet(content);
  last_us_ = time_of(capture_us);
  shift_us_ = last_us_ - capture_us;
  outbox_.push(number_, messages_of(std::move(frame), number_, last_us_));
  ++number_;
}

void FrameSender::send_sound(ByteView packet, std::uint16_t samples, std::uint64_t capture_us) {
  const LiveSound sound{sounds_++, capture_us, samples, packet};
  outbox_.sound(
      {LiveMessage::Kind::binary, std::make_shared<const Bytes>(write_live_sound(sound))});
}

/// Two frames of the same time shift those after them no longer than until the times given have
/// caught up.
std::uint64_t FrameSender::time_of(std::uint64_t capture_us) const {
  if (number_ == 0 || capture_us > last_us_) return capture_us;
  const std::uint64_t shifted = capture_us + shift_us_;
  return shifted > last_us_ ? shifted : last_us_ + frame_duration_us(hello_.fps);
}

void FrameSender::flush() {
  if (number_ == 0 && sounds_ == 0) return;
  outbox_.flush(kFlushTime);
  if (outbox_.trouble().empty()) outbox_.flush(kSlowFlushTime);
}

void FrameSender::greet(const Content& content) {
  LiveHello hello = hello_;
  hello.bounds.grow(content.box);
  hello.colors |= content.colors;
  hello.normals |= content.normals;
  cover(hello.scalars, content.scalars);
  if (!content.scalars.empty()) add_scalar_layer(hello.layer_names);
  if (greeted_ && hello == hello_) return;
  greeted_ = true;
  hello_ = std::move(hello);
  outbox_.hello(text_message(write_publisher_hello(hello_, identity_)));
}

std::string stream_name_of(const std::string& url) { return url.substr(url.rfind('/') + 1); }

Result<std::string> publishing_address(const std::string& url) {
  TRY(parse_websocket_url(url));
  if (url.find_first_of("?#") != std::string::npos || !is_stream_address(url))
    return fail(ErrorCode::argument, without_secrets(url) + ": " + kNoStreamAddress);
  return url + "?publish";  // a viewer would connect without the query
}

}  // namespace pointreel
