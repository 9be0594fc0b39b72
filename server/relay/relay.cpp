#include "server/relay/relay.h"

#include <algorithm>
#include <list>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <random>
#include <string_view>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "codec/live/live_sound.h"
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
  struct Watcher {
    std::function<void()> wake;
    bool asleep = false;
    bool due = true;  ///< the names may have changed since it was told them
  };

  /// A stream has got its publisher, or lost it.
  void changed() {
    const std::lock_guard lock(mutex);
    for (Watcher& watcher : watchers) {
      watcher.due = true;
      if (!watcher.asleep) continue;
      try {
        watcher.wake();
        watcher.asleep = false;
      } catch (const std::bad_alloc&) {
        // It sleeps on until the next change.
      }
    }
  }

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
  std::list<Watcher> watchers;
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
  enum class From { kPublisher, kServer };

  StreamPublication(std::shared_ptr<RelayState> state, std::string name, From from)
      : state_(std::move(state)), name_(std::move(name)), from_(from) {}
  ~StreamPublication() override { leave(); }

  Result<void> message(LiveMessage message) override {
    if (message.kind == LiveMessage::Kind::binary) {
      if (!greeted()) return fail("the first message must be a hello");
      if (is_live_sound(*message.bytes)) return use_->stream().sound(this, std::move(message));
      return use_->stream().layer(this, std::move(message));
    }
    const std::string_view text(reinterpret_cast<const char*>(message.bytes->data()),
                                message.bytes->size());
    if (from_ == From::kServer) return take(TRY(parse_live_text(text)));
    auto publisher = TRY(parse_publisher_text(text));
    if (!publisher) return {};
    publisher->hello.servers = {state_->options.server};
    return greet(std::move(publisher->hello), proofs_of(publisher->identity));
  }

  bool greeted() const override { return use_ != nullptr; }
  void end() override { ended_ = true; }

 private:
  /// What another server says to its viewers.
  Result<void> take(LiveText text) {
    if (auto* hello = std::get_if<LiveHello>(&text)) {
      auto& servers = hello->servers;
      if (std::ranges::find(servers, state_->options.server) != servers.end())
        return fail(fmt::format("{} comes from this server: the servers relay in a circle", name_));
      if (servers.size() >= kMaxLiveServers)
        return fail(fmt::format("{} has passed through {} servers already", name_, servers.size()));
      servers.push_back(state_->options.server);
      // Its publisher was started again.
      if (hello->session != session_) leave();
      session_ = hello->session;
      return greet(std::move(*hello), {proof_of_session(session_)});
    }
    if (const auto* drops = std::get_if<LiveDrops>(&text)) {
      // They count from the beginning of the connection, and a hostile server may count backward.
      if (greeted() && drops->frames >= drops_.frames && drops->layers >= drops_.layers)
        use_->stream().lost({drops->frames - drops_.frames, drops->layers - drops_.layers});
      drops_ = *drops;
    } else if (std::holds_alternative<LiveEnd>(text)) {
      leave();
    }
    return {};
  }

  Result<void> greet(LiveHello hello, const SessionProofs& proofs) {
    // Of two servers that have the same stream, the second waits until the first has gone.
    const bool may_replace = from_ == From::kPublisher;
    if (greeted()) return use_->stream().hello(this, std::move(hello), proofs, may_replace, now());
    std::unique_ptr<Use> use = TRY(use_for_publisher(state_, name_));
    TRY(use->stream().hello(this, std::move(hello), proofs, may_replace, now()));
    use_ = std::move(use);
    state_->changed();
    return {};
  }

  void leave() {
    if (!greeted()) return;
    const bool is_free = ended_ || from_ == From::kServer;
    use_->stream().leave(this, is_free ? Stream::Time::min() : now() + state_->options.grace);
    use_.reset();
    state_->changed();
  }

  Stream::Time now() const { return state_->options.now(); }

  const std::shared_ptr<RelayState> state_;
  const std::string name_;
  const From from_;
  bool ended_ = false;
  std::uint64_t session_ = 0;  ///< from a server
  LiveDrops drops_;            ///< from a server: those that were counted
  std::unique_ptr<Use> use_;   ///< null before the hello
};

/// Tells the names of the streams.
class ListViewer : public Viewer {
 public:
  ListViewer(std::shared_ptr<RelayState> state, std::function<void()> wake)
      : state_(std::move(state)) {
    const std::lock_guard lock(state_->mutex);
    watcher_ = state_->watchers.insert(state_->watchers.end(), {std::move(wake)});
  }
  ~ListViewer() override {
    const std::lock_guard lock(state_->mutex);
    state_->watchers.erase(watcher_);
  }

  std::optional<LiveMessage> next() override {
    const std::lock_guard lock(state_->mutex);
    watcher_->asleep = !watcher_->due;
    if (!watcher_->due) return std::nullopt;
    LiveStreams streams;
    for (const auto& [name, entry] : state_->streams) {
      if (streams.names.size() < kMaxLiveStreams && entry.stream->is_publishing())
        streams.names.push_back(name);
    }
    LiveMessage message = text_message(write_streams(streams));
    watcher_->due = false;
    return message;
  }

 private:
  std::shared_ptr<RelayState> state_;
  std::list<RelayState::Watcher>::iterator watcher_;
};

class StreamViewer : public Viewer {
 public:
  StreamViewer(std::unique_ptr<Use> use, std::function<void()> wake, bool sound)
      : use_(std::move(use)), seat_(use_->stream().join(std::move(wake), sound)) {}
  ~StreamViewer() override { use_->stream().leave(seat_); }

  std::optional<LiveMessage> next() override { return use_->stream().next(*seat_); }

 private:
  std::unique_ptr<Use> use_;
  std::shared_ptr<Seat> seat_;
};

}  // namespace

std::uint64_t random_server() {
  std::random_device random;
  return std::uint64_t{random()} << 32 | random();
}

Relay::Relay(RelayOptions options) : state_(new RelayState{std::move(options), {}, {}, 0, {}}) {}

Relay::~Relay() = default;

namespace {

Result<std::unique_ptr<Publication>> publication(const std::shared_ptr<RelayState>& state,
                                                 const std::string& name,
                                                 StreamPublication::From from) {
  if (!is_stream_name(name)) {
    return fail(ErrorCode::argument,
                "a stream's name consists of 1 to 64 letters, digits, '.', '_' and '-'");
  }
  return std::make_unique<StreamPublication>(state, name, from);
}

}  // namespace

Result<std::unique_ptr<Publication>> Relay::publish(const std::string& name) {
  return publication(state_, name, StreamPublication::From::kPublisher);
}

Result<std::unique_ptr<Publication>> Relay::receive(const std::string& name) {
  return publication(state_, name, StreamPublication::From::kServer);
}

std::unique_ptr<Viewer> Relay::watch(std::function<void()> wake) {
  return std::make_unique<ListViewer>(state_, std::move(wake));
}

Result<std::unique_ptr<Viewer>> Relay::join(const std::string& name, std::function<void()> wake,
                                            bool sound) {
  auto use = std::make_unique<Use>(state_, name);
  std::unique_lock lock(state_->mutex);
  const auto found = state_->streams.find(name);
  if (found == state_->streams.end()) {
    return fail(ErrorCode::not_found, fmt::format("nobody publishes {}", name));
  }
  use->begin(found->second);
  lock.unlock();
  return std::make_unique<StreamViewer>(std::move(use), std::move(wake), sound);
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
