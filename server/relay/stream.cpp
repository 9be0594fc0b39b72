#include "server/relay/stream.h"

#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "common/base/try.h"

namespace pointreel {

Result<void> Stream::message(const void* publisher, LiveMessage message) {
  const std::lock_guard lock(mutex_);
  if (message.kind == LiveMessage::Kind::text) return text(publisher, std::move(message));
  if (owner_ != publisher) {
    return fail(replaced_ == publisher ? "the publisher has connected anew"
                                       : "the first message must be a hello");
  }
  return layer(std::move(message));
}

void Stream::leave(const void* publisher) {
  const std::lock_guard lock(mutex_);
  if (replaced_ == publisher) replaced_ = nullptr;
  if (owner_ != publisher) return;
  owner_ = nullptr;
  for (const auto& sink : sinks_) sink->end();
  const LiveMessage end = text_message(write_end());
  for (const auto& seat : seats_) {
    seat->queue.end(end);
    wake(*seat);
  }
}

std::shared_ptr<Seat> Stream::join(std::function<void()> wake) {
  const std::lock_guard lock(mutex_);
  auto seat = std::make_shared<Seat>(Seat{LiveQueue(options_), std::move(wake), false});
  if (hello_.bytes) seat->queue.hello(hello_, true);
  for (std::size_t i = 0; i < newest_.size(); ++i) {
    seat->queue.push(last_.frame, static_cast<std::uint8_t>(i), last_.layers, newest_[i]);
  }
  if (owner_ == nullptr) seat->queue.end(text_message(write_end()));
  seats_.push_back(seat);
  return seat;
}

void Stream::leave(const std::shared_ptr<Seat>& seat) {
  const std::lock_guard lock(mutex_);
  drops_of_gone_.frames += seat->queue.drops().frames;
  drops_of_gone_.layers += seat->queue.drops().layers;
  std::erase(seats_, seat);
}

std::optional<LiveMessage> Stream::next(Seat& seat) {
  const std::lock_guard lock(mutex_);
  std::optional<LiveMessage> message = seat.queue.next();
  seat.asleep = !message;
  if (message) sent_bytes_ += message->size();
  return message;
}

StreamStatistics Stream::statistics() const {
  const std::lock_guard lock(mutex_);
  StreamStatistics statistics;
  statistics.name = name_;
  statistics.publishing = owner_ != nullptr;
  statistics.viewers = seats_.size();
  statistics.frames = frames_;
  statistics.layers = layers_;
  statistics.bytes = bytes_;
  statistics.sent_bytes = sent_bytes_;
  statistics.drops = drops_of_gone_;
  for (const auto& seat : seats_) {
    statistics.drops.frames += seat->queue.drops().frames;
    statistics.drops.layers += seat->queue.drops().layers;
  }
  statistics.newest_capture_us = newest_.empty() ? 0 : last_.capture_us;
  return statistics;
}

Result<void> Stream::text(const void* publisher, LiveMessage message) {
  const std::string_view view(reinterpret_cast<const char*>(message.bytes->data()),
                              message.bytes->size());
  const LiveText parsed = TRY(parse_live_text(view));
  if (std::holds_alternative<LiveUnknown>(parsed)) return {};
  const LiveHello* hello = std::get_if<LiveHello>(&parsed);
  if (hello == nullptr) return fail("publishers may send only hellos and layers");
  const bool same_session = hello_.bytes && hello->session == parsed_hello_.session;
  if (owner_ != nullptr && owner_ != publisher) {
    if (!same_session) return fail(fmt::format("somebody else publishes {} already", name_));
    replaced_ = owner_;
  }
  if (owner_ == publisher && !same_session) {
    return fail("the session may not change within a connection");
  }
  resent_ = resent_ || (same_session && owner_ != publisher);
  owner_ = publisher;
  parsed_hello_ = *hello;
  hello_ = std::move(message);
  if (!same_session) newest_.clear();
  for (const auto& sink : sinks_) sink->hello(parsed_hello_);
  for (const auto& seat : seats_) {
    seat->queue.hello(hello_, !same_session);
    wake(*seat);
  }
  return {};
}

Result<void> Stream::layer(LiveMessage message) {
  const LiveLayer parsed = TRY(parse_live_layer(*message.bytes));
  if (parsed.layers > parsed_hello_.layer_names.size()) {
    return fail(fmt::format("layer: {} layers, the hello names {}", parsed.layers,
                            parsed_hello_.layer_names.size()));
  }
  // A publisher that has reconnected sends its newest frame again, of which some layers may already
  // have come.
  const bool again =
      !newest_.empty() &&
      (parsed.frame < last_.frame || (parsed.frame == last_.frame && parsed.layer <= last_.layer));
  if (resent_ && again) return {};
  if (parsed.layer == 0) {
    resent_ = false;
    if (!newest_.empty() && parsed.frame <= last_.frame) {
      return fail(fmt::format("layer: frame {} after {}", parsed.frame, last_.frame));
    }
    newest_.clear();
    ++frames_;
  } else if (newest_.empty() || parsed.frame != last_.frame || parsed.layer != last_.layer + 1 ||
             parsed.layers != last_.layers || parsed.capture_us != last_.capture_us) {
    return fail(fmt::format("layer: {} of frame {} does not follow what came before it",
                            parsed.layer, parsed.frame));
  }
  last_ = parsed;
  last_.bytes = {};
  ++layers_;
  bytes_ += message.size();
  for (const auto& sink : sinks_) sink->layer(parsed, message);
  for (const auto& seat : seats_) {
    seat->queue.push(parsed.frame, parsed.layer, parsed.layers, message);
    wake(*seat);
  }
  newest_.push_back(std::move(message));
  return {};
}

void Stream::wake(Seat& seat) {
  if (!seat.asleep || seat.queue.empty()) return;
  seat.asleep = false;
  seat.wake();
}

}  // namespace pointreel
