#include "server/upstream/upstream.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <random>
#include <ranges>
#include <stop_token>
#include <string_view>
#include <thread>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "common/base/backoff.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"
#include "common/net/websocket.h"
#include "server/relay/rate_limit.h"

namespace pointreel {
namespace {

using namespace std::chrono_literals;
using std::chrono::milliseconds;

/// A server that has disappeared is noticed after this time, and one that is there again is found
/// within the pause.
constexpr milliseconds kSilence = 1500ms;
constexpr milliseconds kFirstPause = 100ms, kMostPause = 500ms;
/// After a refusal, which another attempt hardly changes.
constexpr milliseconds kFirstRefusal = 1000ms, kMostRefusal = 10'000ms;
/// Attempts to connect get longer, because a slow link takes several seconds for TLS.
constexpr milliseconds kConnect = 1500ms, kMostConnect = 12'000ms;
/// What waits between the socket and the relay, which takes it at once.
constexpr std::size_t kMaxWaiting = 4u << 20;

/// `more`: others wait behind the message.
using Take = std::function<Result<void>(WebSocketMessage message, bool more)>;

/// Keeps up a connection in a thread of its own. `begin` is called for each connection, and what it
/// returns gets the messages and is destroyed with the connection; an error from it ends that.
class Link {
 public:
  Link(const UpstreamOptions& options, std::string url, std::function<Take()> begin)
      : options_(options),
        url_(std::move(url)),
        begin_(std::move(begin)),
        thread_([this](const std::stop_token& stop) { run(stop); }) {}

  void request_stop() { thread_.request_stop(); }

 private:
  void run(const std::stop_token& stop) {
    Backoff<milliseconds> pause(kFirstPause, kMostPause), refusal(kFirstRefusal, kMostRefusal);
    Backoff<milliseconds> connect(kConnect, kMostConnect);
    while (!stop.stop_requested()) {
      WebSocketOptions socket_options;
      socket_options.token = options_.token;
      socket_options.option_prefix = "--relay-";
      socket_options.ca_file = options_.ca_file;
      socket_options.connect_timeout = connect.wait();
      socket_options.silence_timeout = kSilence;
      socket_options.max_message = options_.max_message;
      socket_options.max_waiting = kMaxWaiting;
      socket_options.stop = stop;
      const auto socket = WebSocket::connect(url_, socket_options);
      bool refused = false;
      if (socket) {
        connect.succeeded();
        pause.succeeded();
        refused = !serve(**socket, stop);
        if (!refused) refusal.succeeded();
      } else {
        connect.failed();
        refused = socket.error().code == ErrorCode::refused;
        tell(socket.error().message);
      }
      wait(refused ? refusal.wait() : pause.wait(), stop);
      (refused ? refusal : pause).failed();
    }
  }

  /// Passes messages on until the connection ends. False if one of them was refused.
  bool serve(WebSocket& socket, const std::stop_token& stop) {
    const std::stop_callback closing(stop, [&] { socket.close(); });
    const Take take = begin_();
    RateLimit text(options_.text_rate);
    // What has come is not taken any more once this is to stop.
    while (!stop.stop_requested()) {
      auto message = socket.receive(1h);
      if (!message) {
        if (!stop.stop_requested()) tell(message.error().message);
        return true;
      }
      if (!*message) continue;
      if ((*message)->kind == WebSocket::Kind::text) {
        text.add((*message)->bytes.size());
        if (text.is_exceeded()) {
          tell(fmt::format("{}: sends more than {} bytes of text a second", url_, text.rate()));
          return false;
        }
        wait(std::min<std::chrono::steady_clock::duration>(text.ahead(), 1s), stop);
      }
      const Result<void> taken =
          or_out_of_memory([&] { return take(*std::move(*message), socket.waiting() > 0); });
      if (!taken) {
        tell(fmt::format("{}: {}", url_, taken.error().message));
        return false;
      }
      tell({});
    }
    return true;
  }

  void wait(std::chrono::steady_clock::duration pause, const std::stop_token& stop) {
    if (pause <= pause.zero()) return;
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, stop, jittered(pause, random_), [] { return false; });
  }

  /// Empty: nothing is wrong any more.
  void tell(const std::string& trouble) {
    if (trouble == trouble_) return;
    trouble_ = trouble;
    if (options_.say)
      options_.say(trouble.empty() ? url_ + ": connected again" : trouble + "; trying again");
  }

  const UpstreamOptions& options_;
  const std::string url_;
  const std::function<Take()> begin_;
  std::string trouble_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::minstd_rand random_{std::random_device{}()};
  std::jthread thread_;
};

class StreamsOfServer : public Upstream {
 public:
  StreamsOfServer(Relay& relay, UpstreamOptions options)
      : relay_(relay), options_(std::move(options)) {
    if (!options_.stream.empty()) {
      if (auto link = stream(options_.url, options_.stream))
        streams_.emplace(options_.stream, std::move(link));
    } else {
      list_ = std::make_unique<Link>(options_, options_.url, [this] {
        newest_.reset();
        return [this](WebSocketMessage message, bool more) {
          return take_list(std::move(message), more);
        };
      });
    }
  }
  ~StreamsOfServer() override {
    list_.reset();
    // Each takes up to half a second for its end.
    for (const auto& link : std::views::values(streams_)) link->request_stop();
  }

 private:
  std::unique_ptr<Link> stream(const std::string& url, const std::string& there) {
    std::string here = options_.name;
    if (const auto star = here.find('*'); star != std::string::npos) here.replace(star, 1, there);
    if (!is_stream_name(here)) {
      if (options_.say) options_.say(fmt::format("{}: the name {} is too long", url, here));
      return nullptr;
    }
    return std::make_unique<Link>(options_, url + "?sound", [this, here] {
      const std::shared_ptr<Publication> publication = relay_.receive(here).value();
      return [publication](WebSocketMessage message, bool) {
        const bool is_text = message.kind == WebSocket::Kind::text;
        return publication->message({is_text ? LiveMessage::Kind::text : LiveMessage::Kind::binary,
                                     std::make_shared<const Bytes>(std::move(message.bytes))});
      };
    });
  }

  /// Follows the streams that are published there, and leaves those that are not. Of several lists,
  /// only the newest counts: each may mean as many new connections as there may be streams.
  Result<void> take_list(WebSocketMessage message, bool more) {
    if (message.kind != WebSocket::Kind::text) return fail("sends frames instead of names");
    LiveText text = TRY(parse_live_text(
        {reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size()}));
    if (auto* const list = std::get_if<LiveStreams>(&text)) newest_ = std::move(*list);
    if (newest_ && !more) follow(*std::exchange(newest_, std::nullopt));
    return {};
  }

  void follow(const LiveStreams& list) {
    std::map<std::string, std::unique_ptr<Link>> gone;
    std::swap(gone, streams_);
    for (const std::string& name : list.names) {
      if (auto kept = gone.extract(name)) {
        streams_.insert(std::move(kept));
      } else if (!streams_.contains(name)) {
        if (auto link = stream(fmt::format("{}/{}", options_.url, name), name))
          streams_.emplace(name, std::move(link));
      }
    }
    for (const auto& link : std::views::values(gone)) link->request_stop();
  }

  Relay& relay_;
  const UpstreamOptions options_;
  std::map<std::string, std::unique_ptr<Link>> streams_;  ///< by their names there
  std::optional<LiveStreams> newest_;                     ///< a list that is to be followed
  std::unique_ptr<Link> list_;                            ///< null for a single stream
};

}  // namespace

Result<UpstreamOptions> parse_upstream(const std::string& text) {
  UpstreamOptions options;
  const auto equals = text.find('=');
  const bool is_named = equals != std::string::npos && equals < text.find("://");
  options.url = is_named ? text.substr(equals + 1) : text;
  while (options.url.ends_with('/')) options.url.pop_back();
  const Url url = TRY(parse_websocket_url(options.url));
  constexpr std::string_view kList = "/live";
  const std::string_view path = url.target;
  if (!path.ends_with(kList)) {
    const auto slash = path.rfind('/');
    options.stream = path.substr(slash + 1);
    if (!path.substr(0, slash).ends_with(kList) || !is_stream_name(options.stream)) {
      return fail(ErrorCode::argument,
                  text + ": does not end with /live for all streams, or /live/NAME for one");
    }
  }
  if (!is_named) return options;
  options.name = text.substr(0, equals);
  const auto star = options.name.find('*');
  std::string example = options.name;
  if (star != std::string::npos) example[star] = 'x';
  if (!is_stream_name(example)) {
    return fail(ErrorCode::argument,
                text +
                    ": a stream's name consists of 1 to 64 letters, digits, '.', '_' and '-', "
                    "and at most one * for the name on the other server");
  }
  if (options.stream.empty() && star == std::string::npos) {
    return fail(ErrorCode::argument,
                text + ": the name needs a * that stands for the names on the other server");
  }
  return options;
}

Result<std::unique_ptr<Upstream>> Upstream::start(Relay& relay, UpstreamOptions options) {
  WebSocketOptions socket_options;
  socket_options.ca_file = options.ca_file;
  TRY(check_websocket(options.url, socket_options));
  return std::make_unique<StreamsOfServer>(relay, std::move(options));
}

}  // namespace pointreel
