#include "client/source/websocket_live_source.h"

#include <condition_variable>
#include <mutex>
#include <random>
#include <string_view>
#include <thread>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "client/source/live_assembler.h"
#include "common/base/backoff.h"
#include "common/base/try.h"
#include "common/net/url.h"
#include "common/net/websocket.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLook{200};  ///< how long it takes to notice that it is to stop

WebSocketOptions socket_options(const SourceOptions& source) {
  WebSocketOptions options;
  options.token = source.token;
  options.ca_file = source.ca_file;
  options.silence_timeout = source.stall_timeout;
  options.max_message = kLiveHeaderSize + kMaxLiveLayer;
  return options;
}

std::string with_sound(const std::string& url) {
  return url + (url.find('?') == std::string::npos ? "?sound" : "&sound");
}

class WebSocketLiveSource : public LiveSource {
 public:
  WebSocketLiveSource(const std::string& url, const SourceOptions& options)
      : url_(without_secrets(url)),
        address_(options.sound ? with_sound(url) : url),
        options_(options) {
    thread_ = std::thread([this] { run(); });
  }
  ~WebSocketLiveSource() override {
    WebSocketLiveSource::cancel();
    thread_.join();
  }

  std::optional<LiveHello> hello(milliseconds timeout) override {
    return assembler_.hello(timeout);
  }
  std::optional<LiveFrame> next(milliseconds timeout) override { return assembler_.next(timeout); }
  LiveCounts counts() const override { return assembler_.counts(); }

  std::optional<Error> refusal() const override {
    const std::lock_guard lock(mutex_);
    return refusal_;
  }

  void set_on_sound(OnSound on_sound) override {
    const std::lock_guard lock(sound_mutex_);
    on_sound_ = std::move(on_sound);
  }

  std::optional<std::string> trouble() const override {
    const std::lock_guard lock(mutex_);
    return trouble_;
  }

  void cancel() override {
    stop_.request_stop();
    assembler_.cancel();
    const std::lock_guard lock(mutex_);
    changed_.notify_all();
  }

 private:
  void run() {
    Backoff<milliseconds> pause(options_.first_backoff, options_.max_backoff);
    Backoff<milliseconds> connect_timeout(options_.connect_timeout, 8 * options_.connect_timeout);
    bool connected_before = false;
    while (!stop_.stop_requested()) {
      WebSocketOptions options = socket_options(options_);
      options.connect_timeout = connect_timeout.wait();
      options.stop = stop_.get_token();
      auto socket = WebSocket::connect(address_, options);
      if (socket) {
        connect_timeout.succeeded();
        if (std::exchange(connected_before, true)) assembler_.reconnected();
        if (receive(**socket)) pause.succeeded();
      } else if (!connected_before && socket.error().code == ErrorCode::refused) {
        refused(socket.error());
        return;
      } else {
        connect_timeout.failed();
        set_trouble(reason(socket.error()));
      }
      wait(pause.wait());
      pause.failed();
    }
  }

  void refused(const Error& error) {
    {
      const std::lock_guard lock(mutex_);
      refusal_ = error;
    }
    set_trouble(error.message);
    assembler_.cancel();
  }

  /// Receives until the connection ends. True if anything came.
  bool receive(WebSocket& socket) {
    bool came = false;
    while (!stop_.stop_requested()) {
      auto message = socket.receive(kLook);
      if (!message) {
        // What a server says in vain is more use than that it hung up then.
        if (!bad_text_) set_trouble(message.error().message + "; connecting again");
        break;
      }
      if (!*message) continue;
      came = true;
      if ((*message)->kind == WebSocket::Kind::binary && is_live_sound((*message)->bytes)) {
        take_sound((*message)->bytes);
      } else if ((*message)->kind == WebSocket::Kind::binary) {
        take_layer(std::move((*message)->bytes));
      } else {
        const Bytes& bytes = (*message)->bytes;
        take_text({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
      }
    }
    return came;
  }

  void take_layer(const SharedBytes& message) {
    if (const auto layer = parse_live_layer(message.view()))
      assembler_.add(*layer, message.part(kLiveHeaderSize, layer->bytes.size()));
    else
      assembler_.add_bad();
  }

  void take_sound(ByteView message) {
    const auto sound = parse_live_sound(message);
    const std::lock_guard lock(sound_mutex_);
    if (!sound)
      assembler_.add_bad();
    else if (on_sound_)
      on_sound_(*sound);
  }

  void take_text(std::string_view text) {
    auto parsed = parse_live_text(text);
    bad_text_ = !parsed;
    if (!parsed) {
      assembler_.add_bad();
      set_trouble(url_ +
                  ": what the server says of the stream is invalid: " + parsed.error().message);
    } else if (auto* hello = std::get_if<LiveHello>(&*parsed)) {
      set_trouble(std::nullopt);
      assembler_.add(std::move(*hello));
    } else if (const auto* drops = std::get_if<LiveDrops>(&*parsed)) {
      assembler_.set_dropped(drops->layers);
    } else if (std::holds_alternative<LiveEnd>(*parsed)) {
      set_trouble(url_ + ": the publisher has gone; waiting for it");
    }
  }

  std::string reason(const Error& error) const {
    if (error.code == ErrorCode::not_found) return url_ + ": waiting for the publisher";
    return error.message + "; trying again";
  }

  void set_trouble(const std::optional<std::string>& text) {
    {
      const std::lock_guard lock(mutex_);
      if (text == trouble_) return;
      trouble_ = text;
    }
    if (options_.on_trouble) options_.on_trouble(text);
  }

  void wait(milliseconds pause) {
    const auto shortened = jittered(pause, random_);
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, shortened, [this] { return stop_.stop_requested(); });
  }

  const std::string url_, address_;  ///< for people, and with what is asked for
  const SourceOptions options_;
  LiveAssembler assembler_;
  std::mutex sound_mutex_;
  OnSound on_sound_;
  std::stop_source stop_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<std::string> trouble_;
  std::optional<Error> refusal_;
  bool bad_text_ = false;  ///< the last text was invalid; only the thread uses it
  std::minstd_rand random_{std::random_device{}()};
  std::thread thread_;
};

}  // namespace

Result<std::unique_ptr<LiveSource>> open_websocket_live_source(const std::string& url,
                                                               const SourceOptions& options) {
  TRY(check_websocket(url, socket_options(options)));
  if (!is_stream_address(url))
    return fail(ErrorCode::argument, without_secrets(url) + ": " + kNoStreamAddress);
  return std::make_unique<WebSocketLiveSource>(url, options);
}

}  // namespace pointreel
