#include "server/relay/relay.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace pointreel {
namespace {

/// A viewer as its stream sees it.
struct Seat {
  ViewerQueue queue;
  std::function<void()> wake;
  bool asleep = false;  ///< the viewer was told that nothing waits
};

/// One stream. A lock of its own, so that streams do not wait for each other.
class Stream {
 public:
  Stream(std::string name, const ViewerLimits& limits, std::vector<std::shared_ptr<LiveSink>> sinks)
      : name_(std::move(name)), limits_(limits), sinks_(std::move(sinks)) {}

  /// A new publisher is `owner` once its hello is taken; before that it is nobody.
  Result<void> message(const void* owner, LiveMessage message) {
    const std::lock_guard lock(mutex_);
    if (message.kind == LiveMessage::Kind::text) return text(owner, std::move(message));
    if (owner_ != owner) {
      return fail(taken_from_ == owner ? "the publisher has connected anew"
                                       : "the first message must be a hello");
    }
    return layer(std::move(message));
  }

  void leave(const void* owner) {
    const std::lock_guard lock(mutex_);
    if (taken_from_ == owner) taken_from_ = nullptr;
    if (owner_ != owner) return;
    owner_ = nullptr;
    for (const auto& sink : sinks_) sink->end();
    const LiveMessage end = text_message(write_end());
    for (const auto& seat : seats_) {
      seat->queue.end(end);
      wake(*seat);
    }
  }

  std::shared_ptr<Seat> join(std::function<void()> wake) {
    const std::lock_guard lock(mutex_);
    auto seat = std::make_shared<Seat>(Seat{ViewerQueue(limits_), std::move(wake), false});
    if (hello_.bytes) seat->queue.hello(hello_, true);
    for (std::size_t i = 0; i < newest_.size(); ++i) {
      seat->queue.push(last_.frame, static_cast<std::uint8_t>(i), last_.layers, newest_[i]);
    }
    if (owner_ == nullptr) seat->queue.end(text_message(write_end()));
    seats_.push_back(seat);
    return seat;
  }

  void leave(const std::shared_ptr<Seat>& seat) {
    const std::lock_guard lock(mutex_);
    gone_.frames += seat->queue.drops().frames;
    gone_.layers += seat->queue.drops().layers;
    std::erase(seats_, seat);
  }

  std::optional<LiveMessage> next(Seat& seat) {
    const std::lock_guard lock(mutex_);
    std::optional<LiveMessage> message = seat.queue.next();
    seat.asleep = !message;
    if (message) sent_bytes_ += message->bytes->size();
    return message;
  }

  StreamStatistics statistics() const {
    const std::lock_guard lock(mutex_);
    StreamStatistics statistics;
    statistics.name = name_;
    statistics.publishing = owner_ != nullptr;
    statistics.viewers = seats_.size();
    statistics.frames = frames_;
    statistics.layers = layers_;
    statistics.bytes = bytes_;
    statistics.sent_bytes = sent_bytes_;
    statistics.drops = gone_;
    for (const auto& seat : seats_) {
      statistics.drops.frames += seat->queue.drops().frames;
      statistics.drops.layers += seat->queue.drops().layers;
    }
    statistics.newest_capture_us = newest_.empty() ? 0 : last_.capture_us;
    return statistics;
  }

 private:
  Result<void> text(const void* owner, LiveMessage message) {
    const std::string_view view(reinterpret_cast<const char*>(message.bytes->data()),
                                message.bytes->size());
    Result<LiveText> parsed = parse_live_text(view);
    if (!parsed) return tl::unexpected(parsed.error());
    if (std::holds_alternative<LiveUnknown>(*parsed)) return {};
    const LiveHello* hello = std::get_if<LiveHello>(&*parsed);
    if (hello == nullptr) return fail("a publisher sends hellos and layers only");
    const bool same = hello_.bytes && hello->session == told_.session;
    if (owner_ != nullptr && owner_ != owner) {
      if (!same) return fail(fmt::format("somebody else publishes {} already", name_));
      taken_from_ = owner_;
    }
    if (owner_ == owner && !same) return fail("the session may not change within a connection");
    resent_ = resent_ || (same && owner_ != owner);
    owner_ = owner;
    told_ = *hello;
    hello_ = std::move(message);
    if (!same) newest_.clear();
    for (const auto& sink : sinks_) sink->hello(told_);
    for (const auto& seat : seats_) {
      seat->queue.hello(hello_, !same);
      wake(*seat);
    }
    return {};
  }

  Result<void> layer(LiveMessage message) {
    const Result<LiveLayer> parsed = parse_live_layer(*message.bytes);
    if (!parsed) return tl::unexpected(parsed.error());
    if (parsed->layers > told_.layer_names.size()) {
      return fail(fmt::format("layer: {} layers, the hello names {}", parsed->layers,
                              told_.layer_names.size()));
    }
    // Who has connected anew sends its newest frame again: some of it may have come already.
    const bool again =
        !newest_.empty() && (parsed->frame < last_.frame ||
                             (parsed->frame == last_.frame && parsed->layer <= last_.layer));
    if (resent_ && again) return {};
    if (parsed->layer == 0) {
      resent_ = false;
      if (!newest_.empty() && parsed->frame <= last_.frame) {
        return fail(fmt::format("layer: frame {} after {}", parsed->frame, last_.frame));
      }
      newest_.clear();
      ++frames_;
    } else if (newest_.empty() || parsed->frame != last_.frame ||
               parsed->layer != last_.layer + 1 || parsed->layers != last_.layers ||
               parsed->capture_us != last_.capture_us) {
      return fail(fmt::format("layer: {} of frame {} does not follow what came before it",
                              parsed->layer, parsed->frame));
    }
    last_ = *parsed;
    last_.bytes = {};
    ++layers_;
    bytes_ += message.bytes->size();
    for (const auto& sink : sinks_) sink->layer(*parsed, message);
    for (const auto& seat : seats_) {
      seat->queue.push(parsed->frame, parsed->layer, parsed->layers, message);
      wake(*seat);
    }
    newest_.push_back(std::move(message));
    return {};
  }

  static void wake(Seat& seat) {
    if (!seat.asleep || seat.queue.empty()) return;
    seat.asleep = false;
    seat.wake();
  }

  const std::string name_;
  const ViewerLimits limits_;
  const std::vector<std::shared_ptr<LiveSink>> sinks_;
  mutable std::mutex mutex_;  // of what follows, seats included
  const void* owner_ = nullptr;
  const void* taken_from_ = nullptr;
  bool resent_ = false;  ///< a publisher has connected anew, and nothing new has come yet
  LiveHello told_;
  LiveMessage hello_;
  LiveLayer last_;                   ///< without bytes
  std::vector<LiveMessage> newest_;  ///< layers of the newest frame
  std::vector<std::shared_ptr<Seat>> seats_;
  std::uint64_t frames_ = 0, layers_ = 0, bytes_ = 0, sent_bytes_ = 0;
  LiveDrops gone_;
};

}  // namespace

/// Outlives the relay for as long as publishers and viewers do.
struct RelayState {
  struct Entry {
    std::shared_ptr<Stream> stream;
    std::size_t users = 0;    ///< publications and viewers
    std::uint64_t ended = 0;  ///< when the last of them left, counted in such events
  };

  void release(const std::string& name) {
    const std::lock_guard lock(mutex);
    Entry& entry = streams.find(name)->second;
    if (--entry.users == 0) entry.ended = ++events;
  }

  /// Takes the stream out that nobody has used for longest.
  std::shared_ptr<Stream> evict() {
    auto oldest = streams.end();
    for (auto i = streams.begin(); i != streams.end(); ++i) {
      if (i->second.users > 0) continue;
      if (oldest == streams.end() || i->second.ended < oldest->second.ended) oldest = i;
    }
    if (oldest == streams.end()) return nullptr;
    std::shared_ptr<Stream> stream = std::move(oldest->second.stream);
    streams.erase(oldest);
    return stream;
  }

  const RelayOptions options;
  std::mutex mutex;  // of what follows; streams have their own
  std::map<std::string, Entry, std::less<>> streams;
  std::uint64_t events = 0;
};

namespace {

/// Keeps a stream from being evicted.
class Use {
 public:
  Use(std::shared_ptr<RelayState> state, std::string name)
      : state_(std::move(state)), name_(std::move(name)) {}
  ~Use() { state_->release(name_); }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;

 private:
  std::shared_ptr<RelayState> state_;
  std::string name_;
};

class StreamPublication : public Publication {
 public:
  StreamPublication(std::unique_ptr<Use> use, std::shared_ptr<Stream> stream)
      : use_(std::move(use)), stream_(std::move(stream)) {}
  ~StreamPublication() override { stream_->leave(this); }

  Result<void> message(LiveMessage message) override {
    return stream_->message(this, std::move(message));
  }

 private:
  std::unique_ptr<Use> use_;
  std::shared_ptr<Stream> stream_;
};

class StreamViewer : public Viewer {
 public:
  StreamViewer(std::unique_ptr<Use> use, std::shared_ptr<Stream> stream, std::function<void()> wake)
      : use_(std::move(use)), stream_(std::move(stream)), seat_(stream_->join(std::move(wake))) {}
  ~StreamViewer() override { stream_->leave(seat_); }

  std::optional<LiveMessage> next() override { return stream_->next(*seat_); }

 private:
  std::unique_ptr<Use> use_;
  std::shared_ptr<Stream> stream_;
  std::shared_ptr<Seat> seat_;
};

}  // namespace

Relay::Relay(RelayOptions options) : state_(new RelayState{std::move(options), {}, {}, 0}) {}

Relay::~Relay() = default;

Result<std::unique_ptr<Publication>> Relay::publish(const std::string& name) {
  if (!is_stream_name(name)) {
    return fail("a stream's name has 1 to 64 letters, digits, '.', '_' and '-'");
  }
  std::shared_ptr<Stream> evicted;  // ends without the lock: it may have files to finish
  const std::lock_guard lock(state_->mutex);
  auto found = state_->streams.find(name);
  if (found == state_->streams.end()) {
    if (state_->streams.size() >= state_->options.max_streams) {
      evicted = state_->evict();
      if (evicted == nullptr) {
        return fail(fmt::format("there are {} streams already", state_->streams.size()));
      }
    }
    std::vector<std::shared_ptr<LiveSink>> sinks;
    if (state_->options.sinks) sinks = state_->options.sinks(name);
    auto stream = std::make_shared<Stream>(name, state_->options.viewer, std::move(sinks));
    found = state_->streams.emplace(name, RelayState::Entry{std::move(stream), 0, 0}).first;
  }
  ++found->second.users;
  return std::make_unique<StreamPublication>(std::make_unique<Use>(state_, name),
                                             found->second.stream);
}

Result<std::unique_ptr<Viewer>> Relay::join(const std::string& name, std::function<void()> wake) {
  const std::lock_guard lock(state_->mutex);
  const auto found = state_->streams.find(name);
  if (found == state_->streams.end()) return fail(fmt::format("nobody publishes {}", name));
  ++found->second.users;
  return std::make_unique<StreamViewer>(std::make_unique<Use>(state_, name), found->second.stream,
                                        std::move(wake));
}

std::vector<StreamStatistics> Relay::statistics() const {
  std::vector<std::shared_ptr<Stream>> streams;
  {
    const std::lock_guard lock(state_->mutex);
    for (const auto& [name, entry] : state_->streams) streams.push_back(entry.stream);
  }
  std::vector<StreamStatistics> all;
  for (const auto& stream : streams) all.push_back(stream->statistics());
  return all;
}

}  // namespace pointreel
