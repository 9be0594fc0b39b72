#include "codec/live/outbox.h"

#include <cstring>
#include <utility>

#include "codec/live/live_sound.h"
#include "common/base/concat.h"
#include "pointreel/bytes.h"

namespace pointreel {
namespace {

using namespace std::chrono_literals;

/// Between two attempts to connect. A server that is available again is found within this time.
constexpr auto kPause = 300ms;
/// The same after several connections over which nothing was accepted, such as those for a name
/// that is taken, and while the token is not valid any more.
constexpr auto kLongPause = 2000ms;
/// So many are repeated soon: a broken link is often back at once.
constexpr int kQuickRetries = 3;
/// Links over satellites have round trips of a second, of which TLS takes four.
constexpr auto kConnectTimeout = 10'000ms;
/// If a server's machine disappears, its connection is given up after this time. Until then it
/// looks like a slow link.
constexpr auto kStallTimeout = 4000ms;
constexpr auto kSilenceTimeout = 10'000ms;
/// How often the connection is checked while there is nothing to send.
constexpr auto kCheckInterval = 100ms;
/// The same while the server has not yet accepted everything.
constexpr auto kUnconfirmedInterval = 10ms;

/// The server has nothing to say but why it ends a connection.
constexpr std::size_t kMaxWaiting = 1u << 20;

/// How long the server's reason for ending a connection may take after sending has failed.
constexpr auto kReasonTime = 500ms;

/// The server does not use messages about drops.
constexpr LiveQueueOptions kQueueOptions{.tell_drops = false};

/// Errors that another attempt does not change, such as a wrong address or token. They end an
/// outbox of which nothing was accepted before.
bool is_final(ErrorCode code) {
  return code == ErrorCode::argument || code == ErrorCode::refused || code == ErrorCode::not_found;
}

/// The numbers of a layer's frame and of the layer itself, from its header.
std::pair<std::uint32_t, std::uint8_t> numbers_of(const LiveMessage& message) {
  constexpr std::size_t kFrameAt = 4, kLayerAt = 20;
  const Bytes& header = *message.bytes;
  std::uint32_t frame = 0;
  std::memcpy(&frame, header.data() + kFrameAt, sizeof(frame));
  return {frame, header[kLayerAt]};
}

}  // namespace

Outbox::Outbox(OutboxOptions options)
    : options_(std::move(options)),
      queue_(kQueueOptions),
      thread_([this](std::stop_token stop) { run(stop); }) {}

Outbox::~Outbox() = default;

void Outbox::hello(LiveMessage message) {
  const std::lock_guard lock(mutex_);
  hello_ = message;
  queue_.hello(std::move(message), false);
  changed_.notify_all();
}

void Outbox::push(std::uint32_t frame, std::vector<LiveMessage> layers) {
  const std::lock_guard lock(mutex_);
  const auto count = static_cast<std::uint8_t>(layers.size());
  for (std::uint8_t i = 0; i < count; ++i) queue_.push(frame, i, count, layers[i]);
  frame_ = frame;
  newest_ = std::move(layers);
  changed_.notify_all();
}

void Outbox::sound(LiveMessage message) {
  const std::lock_guard lock(mutex_);
  if (!hello_.bytes) return;
  queue_.sound(std::move(message));
  changed_.notify_all();
}

void Outbox::wait_until_tried(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, stop, kConnectTimeout,
                    [&] { return statistics_.connections > 0 || failure_ || !trouble_.empty(); });
}

std::optional<Error> Outbox::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

void Outbox::flush(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [&] {
    const bool sent = hello_.bytes && queue_.empty() && !sending_;
    return failure_ || (sent && unconfirmed_.empty() && trouble_.empty());
  });
}

std::string Outbox::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

OutboxStatistics Outbox::statistics() const {
  const std::lock_guard lock(mutex_);
  OutboxStatistics statistics = statistics_;
  statistics.drops.frames += queue_.drops().frames;
  statistics.drops.layers += queue_.drops().layers;
  return statistics;
}

void Outbox::run(const std::stop_token& stop) {
  WebSocketOptions socket_options;
  socket_options.token = options_.token;
  socket_options.ca_file = options_.ca_file;
  socket_options.connect_timeout = kConnectTimeout;
  socket_options.silence_timeout = kSilenceTimeout;
  socket_options.stall_timeout = kStallTimeout;
  socket_options.max_message = kMaxLiveText;
  socket_options.max_waiting = kMaxWaiting;
  socket_options.confirm = true;
  socket_options.stop = stop;
  int in_vain = 0;  // consecutive connections over which nothing was accepted
  while (!stop.stop_requested()) {
    const auto socket = WebSocket::connect(options_.url, socket_options);
    if (socket) {
      restart();
      const std::uint64_t accepted = statistics().accepted_layers;
      serve(**socket, stop);
      in_vain = statistics().accepted_layers == accepted ? in_vain + 1 : 0;
    } else if (!stop.stop_requested()) {
      // A server that took frames before may take them again, with a token that is valid again.
      const ErrorCode code = socket.error().code;
      const bool may_pass = code == ErrorCode::refused && statistics().accepted_layers > 0;
      in_vain = may_pass ? kQuickRetries + 1 : 0;
      if (is_final(code) && !may_pass) {
        const std::lock_guard lock(mutex_);
        failure_ = socket.error();
        changed_.notify_all();
        return;
      }
      tell(socket.error().message);
    }
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, stop, in_vain > kQuickRetries ? kLongPause : kPause,
                      [] { return false; });
  }
}

void Outbox::restart() {
  const std::lock_guard lock(mutex_);
  ++statistics_.connections;
  statistics_.drops.frames += queue_.drops().frames;
  statistics_.drops.layers += queue_.drops().layers;
  queue_ = LiveQueue(kQueueOptions);
  unconfirmed_.clear();
  if (hello_.bytes) queue_.hello(hello_, true);
  const auto count = static_cast<std::uint8_t>(newest_.size());
  for (std::uint8_t i = 0; i < count; ++i) queue_.push(frame_, i, count, newest_[i]);
  changed_.notify_all();
}

void Outbox::serve(WebSocket& socket, const std::stop_token& stop) {
  std::uint64_t messages = 0;
  const std::stop_callback closing(stop, [&] { socket.close(); });
  for (;;) {
    std::optional<LiveMessage> message;
    {
      std::unique_lock lock(mutex_);
      if (stop.stop_requested()) return;
      changed_.wait_for(lock, stop, unconfirmed_.empty() ? kCheckInterval : kUnconfirmedInterval,
                        [&] { return !queue_.empty(); });
      message = queue_.next();
      sending_ = message.has_value();
    }
    const bool is_binary = message && message->kind == LiveMessage::Kind::binary;
    const bool is_layer = is_binary && !is_live_sound(*message->bytes);
    Result<void> sent;
    if (message) {
      sent = socket.send(message->pieces(),
                         is_binary ? WebSocket::Kind::binary : WebSocket::Kind::text);
      if (sent) ++messages;
    } else if (const auto received = socket.receive(0ms); !received) {
      // The server has nothing to say, but it may have closed the connection.
      sent = tl::unexpected(received.error());
    }
    {
      const std::lock_guard lock(mutex_);
      sending_ = false;
      if (sent && is_layer) {
        ++statistics_.layers;
        statistics_.bytes += message->size();
        unconfirmed_.push_back({messages, numbers_of(*message)});
      }
    }
    count_accepted(socket.confirmed());
    if (!sent) {
      // Receiving fails with the server's own reason, which says more.
      Result<std::optional<WebSocketMessage>> why = socket.receive(kReasonTime);
      while (why && *why && !stop.stop_requested()) why = socket.receive(kReasonTime);
      const Error error = why ? sent.error() : why.error();
      if (!stop.stop_requested()) tell(error.message);
      return;
    }
  }
}

void Outbox::count_accepted(std::uint64_t confirmed) {
  bool first = false, recovered = false;
  {
    const std::lock_guard lock(mutex_);
    while (!unconfirmed_.empty() && unconfirmed_.front().message <= confirmed) {
      const auto layer = unconfirmed_.front().layer;
      unconfirmed_.pop_front();
      recovered = recovered || !trouble_.empty();
      trouble_.clear();
      // The newest frame is sent once more over a new connection.
      if (accepted_ && layer <= *accepted_) continue;
      first = first || !accepted_;
      accepted_ = layer;
      ++statistics_.accepted_layers;
      if (layer.second == 0) ++statistics_.accepted_frames;
    }
    changed_.notify_all();
  }
  if (!options_.say) return;
  if (first)
    options_.say(concat("the server has accepted the first frame; \"pointreel play ",
                        options_.url.substr(0, options_.url.find('?')),
                        options_.token.empty() ? "" : " --token TOKEN",
                        options_.ca_file.empty() ? "" : concat(" --ca-file ", options_.ca_file),
                        "\" shows the stream"));
  else if (recovered)
    options_.say("connected again");
}

void Outbox::tell(const std::string& trouble) {
  {
    const std::lock_guard lock(mutex_);
    if (trouble == trouble_) return;
    trouble_ = trouble;
    changed_.notify_all();
  }
  if (options_.say) options_.say(trouble + "; trying again");
}

}  // namespace pointreel
