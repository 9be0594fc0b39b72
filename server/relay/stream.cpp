#include "server/relay/stream.h"

#include <chrono>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "codec/core/reel_rules.h"
#include "codec/live/live_sound.h"
#include "codec/octree/frame_header.h"
#include "common/base/try.h"
#include "common/base/unix_time.h"
#include "common/base/words.h"
#include "server/relay/segmenter.h"

namespace pointreel {
namespace {

bool covers(const Box& outer, const Box& inner) {
  return inner.empty() || (!outer.empty() && glm::all(glm::lessThanEqual(outer.min, inner.min)) &&
                           glm::all(glm::greaterThanEqual(outer.max, inner.max)));
}

/// A hello covers all frames of the session so far, for which earlier ones spoke.
bool takes_back(const LiveHello& before, const LiveHello& now) {
  return (before.colors && !now.colors) || (before.normals && !now.normals) ||
         !covers(now.bounds, before.bounds);
}

}  // namespace

bool Stream::is_owned(Time now) const {
  const std::lock_guard lock(mutex_);
  return owner_ != nullptr || now < reserved_until_;
}

bool Stream::is_publishing() const {
  const std::lock_guard lock(mutex_);
  return owner_ != nullptr;
}

void Stream::lost(const LiveDrops& drops) {
  const std::lock_guard lock(mutex_);
  lost_.frames += drops.frames;
  lost_.layers += drops.layers;
}

void Stream::leave(const void* publisher, Time reserved_until) {
  const std::lock_guard lock(mutex_);
  if (owner_ != publisher) return;
  owner_ = nullptr;
  reserved_until_ = reserved_until;
  for (const auto& sink : sinks_) sink->end();
  for (const auto& seat : seats_) {
    seat->queue.end(end_);
    wake(*seat);
  }
}

std::shared_ptr<Seat> Stream::join(std::function<void()> wake, bool sound) {
  const std::lock_guard lock(mutex_);
  auto seat = std::make_shared<Seat>(Seat{LiveQueue(options_), std::move(wake), sound, false});
  if (hello_.bytes) seat->queue.hello(hello_, true);
  for (std::size_t i = 0; i < newest_.size(); ++i) {
    seat->queue.push(last_.frame, static_cast<std::uint8_t>(i), last_.layers, newest_[i]);
  }
  if (owner_ == nullptr) seat->queue.end(end_);
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
  statistics.hops = parsed_hello_.servers.empty() ? 0 : parsed_hello_.servers.size() - 1;
  statistics.lost = lost_;
  statistics.lag_us = lag_us_;
  statistics.newest_capture_us = newest_.empty() ? 0 : last_.capture_us;
  return statistics;
}

Result<void> Stream::hello(const void* publisher, LiveHello hello, const SessionProofs& proofs,
                           bool may_replace, Time now) {
  const std::lock_guard lock(mutex_);
  const SessionProof& proof = proofs.proof;
  const bool same_session = proof_ == proof;
  const bool other_owner = owner_ != nullptr && owner_ != publisher;
  const bool takes_over = owner_ != publisher && proofs.earlier == proof_;
  const bool known = same_session || takes_over;
  if ((!known && owner_ != nullptr) || (other_owner && !may_replace)) {
    return fail(
        owner_ == publisher
            ? "the secret may not change within a connection"
            : fmt::format("somebody else publishes {} already; choose another name", name_));
  }
  if (!known && now < reserved_until_) {
    const auto left = std::chrono::ceil<std::chrono::seconds>(reserved_until_ - now);
    return fail(fmt::format("{} is kept for {} s for its publisher, which lost its connection",
                            name_, left.count()));
  }
  hello.session = session_of(proof);
  if (same_session && takes_back(parsed_hello_, hello)) {
    return fail("hello: takes back colours, normals or bounds that it has stated before");
  }
  resent_ = resent_ || (same_session && owner_ != publisher);
  owner_ = publisher;
  proof_ = proof;
  parsed_hello_ = std::move(hello);
  hello_ = text_message(write_hello(parsed_hello_));
  if (!same_session) {
    newest_.clear();
    last_sound_.reset();
    cubes_ = {};
  }
  for (const auto& sink : sinks_) sink->hello(parsed_hello_);
  for (const auto& seat : seats_) {
    seat->queue.hello(hello_, !same_session);
    wake(*seat);
  }
  return {};
}

Result<void> Stream::sound(const void* publisher, LiveMessage message) {
  const std::lock_guard lock(mutex_);
  if (owner_ != publisher) return fail("the publisher has connected anew");
  const LiveSound sound = TRY(parse_live_sound(*message.bytes));
  if (last_sound_ && sound.number <= *last_sound_) return {};
  last_sound_ = sound.number;
  bytes_ += message.size();
  for (const auto& sink : sinks_) sink->sound(sound, message);
  for (const auto& seat : seats_) {
    if (!seat->sound) continue;
    seat->queue.sound(message);
    wake(*seat);
  }
  return {};
}

/// Checks what a package would state about the frame.
Result<void> Stream::check_frame(const LiveLayer& layer) {
  TRY(check_chunks(parsed_hello_, layer.layer, layer.sizes, true));
  if (layer.layer > 0) return {};
  const FrameHeader frame = TRY(read_frame_header(layer.bytes.first(layer.sizes.geometry))).header;
  if (pointreel::name(frame.codec) != parsed_hello_.codec) {
    return fail(fmt::format("the codec of the frame is not {}", parsed_hello_.codec));
  }
  if (frame.source_points != layer.points) {
    return fail(fmt::format("{} points, but the frame has {}", layer.points, frame.source_points));
  }
  if (const std::uint32_t most = DecodeLimits().max_points; frame.source_points > most) {
    return fail(ErrorCode::limit, fmt::format("the frame has {} points, and viewers decode {}",
                                              frame.source_points, most));
  }
  if (frame.layers > parsed_hello_.layer_names.size()) {
    return fail(fmt::format("the frame has {}, the hello names {}", counted(frame.layers, "layer"),
                            parsed_hello_.layer_names.size()));
  }
  if (frame.has_colors && !parsed_hello_.colors) return fail("has colours, the hello has none");
  if (frame.has_normals && !parsed_hello_.normals) return fail("has normals, the hello has none");
  TRY(at_place("cube", check_cube(frame.cube)));
  Box cubes = cubes_;
  cubes.grow(box_of(frame.cube));
  TRY(at_place("cube", check_box(cubes)));
  cubes_ = cubes;
  return {};
}

Result<void> Stream::layer(const void* publisher, LiveMessage message) {
  const std::lock_guard lock(mutex_);
  if (owner_ != publisher) return fail("the publisher has connected anew");
  const LiveLayer parsed = TRY(parse_live_layer(*message.bytes));
  if (parsed.layers > parsed_hello_.layer_names.size()) {
    return fail(fmt::format("layer: {}, the hello names {}", counted(parsed.layers, "layer"),
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
    if (!newest_.empty() && parsed.capture_us <= last_.capture_us) {
      return fail(
          fmt::format("layer: captured at {} after {}", parsed.capture_us, last_.capture_us));
    }
    TRY(at_place("layer", check_frame(parsed)));
    newest_.clear();
    ++frames_;
  } else if (newest_.empty() || parsed.frame != last_.frame || parsed.layer != last_.layer + 1 ||
             parsed.layers != last_.layers || parsed.capture_us != last_.capture_us) {
    return fail(fmt::format("layer: {} of frame {} does not follow what came before it",
                            parsed.layer, parsed.frame));
  } else {
    TRY(at_place("layer", check_frame(parsed)));
  }
  // First what may lack memory. If it does, this layer has not come, and the publisher, whose
  // connection ends then, may send it again.
  newest_.push_back(message);
  if (parsed.layer == 0) {
    lag_us_ =
        static_cast<std::int64_t>(unix_time_us()) - static_cast<std::int64_t>(parsed.capture_us);
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
  return {};
}

void Stream::wake(Seat& seat) {
  if (!seat.asleep || seat.queue.empty()) return;
  try {
    seat.wake();
    seat.asleep = false;
  } catch (const std::bad_alloc&) {
    // It sleeps on until the next message comes.
  }
}

}  // namespace pointreel
