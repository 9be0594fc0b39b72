#include "server/relay/relay.h"

#include <map>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "common/base/try.h"
#include "server/relay/stream.h"

namespace pointreel {

/// Shared with publishers and viewers, which may outlive the relay.
struct RelayState {
  struct Entry {
    std::shared_ptr<Stream> stream;
    std::size_t users = 0;    ///< publications and viewers
    std::uint64_t ended = 0;  ///< the value of `events` when the last of them left
  };

  void release(const std::string& name) {
    const std::lock_guard lock(mutex);
    Entry& entry = streams.find(name)->second;
    if (--entry.users == 0) entry.ended = ++events;
  }

  /// Removes the stream that has been unused for the longest time; null if all are in use, or
  /// belong to publishers that may come back.
  std::shared_ptr<Stream> evict() {
    const auto now = options.now();
    auto oldest = streams.end();
    for (auto i = streams.begin(); i != streams.end(); ++i) {
      if (i->second.users > 0 || i->second.stream->is_owned(now)) continue;
      if (oldest == streams.end() || i->second.ended < oldest->second.ended) oldest = i;
    }
    if (oldest == streams.end()) return nullptr;
    std::shared_ptr<Stream> stream = std::move(oldest->second.stream);
    streams.erase(oldest);
    return stream;
  }

  const RelayOptions options;
  std::mutex mutex;  // guards what follows; streams have locks of their own
  std::map<std::string, Entry, std::less<>> streams;
  std::uint64_t events = 0;
};

namespace {

/// Keeps a stream from being evicted, from `begin` on. It is made before, because afterwards
/// nothing may fail, and destroyed without the lock.
class Use {
 public:
  Use(std::shared_ptr<RelayState> state, std::string name)
      : state_(std::move(state)), name_(std::move(name)) {}
  ~Use() {
    if (stream_) state_->release(name_);
  }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;

  /// With the lock held. `entry` is that of the name.
  void begin(RelayState::Entry& entry) {
    ++entry.users;
    stream_ = entry.stream;
  }
  Stream& stream() const { return *stream_; }

 private:
  std::shared_ptr<RelayState> state_;
  std::string name_;
  std::shared_ptr<Stream> stream_;
};

/// The stream of this name, for a publisher. It is created if it does not exist yet; an error if
/// there are too many.
Result<std::unique_ptr<Use>> use_for_publisher(const std::shared_ptr<RelayState>& state,
                                               const std::string& name) {
  std::shared_ptr<Stream> evicted;  // destroyed without the lock, since it may have files to finish
  auto use = std::make_unique<Use>(state, name);
  const std::lock_guard lock(state->mutex);
  auto found = state->streams.find(name);
  if (found == state->streams.end()) {
    if (state->streams.size() >= state->options.max_streams) {
      evicted = state->evict();
      if (evicted == nullptr) {
        return fail(ErrorCode::limit,
                    fmt::format("there are {} streams already", state->streams.size()));
      }
    }
    std::vector<std::shared_ptr<LiveSink>> sinks;
    if (state->options.sinks) sinks = state->options.sinks(name);
    auto stream = std::make_shared<Stream>(name, state->options.viewer, std::move(sinks));
    found = state->streams.emplace(name, RelayState::Entry{std::move(stream), 0, 0}).first;
  }
  use->begin(found->second);
  return use;
}

/// Has its stream once the hello has come.
class StreamPublication : public Publication {
 public:
  StreamPublication(std::shared_ptr<RelayState> state, std::string name)
      : state_(std::move(state)), name_(std::move(name)) {}
  ~StreamPublication() override {
    if (!greeted()) return;
    use_->stream().leave(this, ended_ ? Stream::Time::min() : now() + state_->options.grace);
  }

  Result<void> message(LiveMessage message) override {
    if (message.kind == LiveMessage::Kind::binary) {
      if (!greeted()) return fail("the first message must be a hello");
      return use_->stream().layer(this, std::move(message));
    }
    const std::string_view text(reinterpret_cast<const char*>(message.bytes->data()),
                                message.bytes->size());
    const auto hello = TRY(parse_publisher_text(text));
    if (!hello) return {};
    if (greeted()) return use_->stream().hello(this, *hello, now());
    std::unique_ptr<Use> use = TRY(use_for_publisher(state_, name_));
    TRY(use->stream().hello(this, *hello, now()));
    use_ = std::move(use);
    return {};
  }

  bool greeted() const override { return use_ != nullptr; }
  void end() override { ended_ = true; }

 private:
  Stream::Time now() const { return state_->options.now(); }

  const std::shared_ptr<RelayState> state_;
  const std::string name_;
  bool ended_ = false;
  std::unique_ptr<Use> use_;  ///< null before the hello
};

class StreamViewer : public Viewer {
 public:
  StreamViewer(std::unique_ptr<Use> use, std::function<void()> wake)
      : use_(std::move(use)), seat_(use_->stream().join(std::move(wake))) {}
  ~StreamViewer() override { use_->stream().leave(seat_); }

  std::optional<LiveMessage> next() override { return use_->stream().next(*seat_); }

 private:
  std::unique_ptr<Use> use_;
  std::shared_ptr<Seat> seat_;
};

}  // namespace

Relay::Relay(RelayOptions options) : state_(new RelayState{std::move(options), {}, {}, 0}) {}

Relay::~Relay() = default;

Result<std::unique_ptr<Publication>> Relay::publish(const std::string& name) {
  if (!is_stream_name(name)) {
    return fail(ErrorCode::argument,
                "a stream's name consists of 1 to 64 letters, digits, '.', '_' and '-'");
  }
  return std::make_unique<StreamPublication>(state_, name);
}

Result<std::unique_ptr<Viewer>> Relay::join(const std::string& name, std::function<void()> wake) {
  auto use = std::make_unique<Use>(state_, name);
  std::unique_lock lock(state_->mutex);
  const auto found = state_->streams.find(name);
  if (found == state_->streams.end()) {
    return fail(ErrorCode::not_found, fmt::format("nobody publishes {}", name));
  }
  use->begin(found->second);
  lock.unlock();
  return std::make_unique<StreamViewer>(std::move(use), std::move(wake));
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
