#include "common/net/websocket.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <fmt/format.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include "common/base/try.h"
#include "common/net/client_transport.h"
#include "common/net/http_status.h"
#include "common/net/lookup.h"
#include "common/net/untrusted.h"
#include "common/net/url.h"

namespace pointreel {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using boost::system::error_code;
using Stream = websocket::stream<ClientStream, false>;  // without compression
using Timer = asio::basic_waitable_timer<std::chrono::steady_clock,
                                         asio::wait_traits<std::chrono::steady_clock>,
                                         ClientTransport::Executor>;

/// The time allowed for the closing handshake.
constexpr std::chrono::milliseconds kCloseTime{500};
constexpr std::size_t kWriteBuffer = 64u << 10;
/// Bytes that the system may buffer beyond those in flight. It is small, so that the sender soon
/// notices a slow link and can choose what to send.
constexpr int kUnsentLimit = 64 << 10;
/// The number of bytes of a refusal's body that are quoted in an error.
constexpr std::size_t kMostExcuse = 200;

/// The memory that a message takes while it waits, with its place in a queue and what the allocator
/// adds.
std::size_t memory_of(const WebSocketMessage& message) {
  constexpr std::size_t kBesides = sizeof(WebSocketMessage) + 64;
  return message.bytes.capacity() + kBesides;
}

/// The first line of a server's explanation; nothing of a page for people.
std::string excuse(const std::string& body) {
  if (body.starts_with('<')) return {};
  const std::string line = body.substr(0, std::min(body.find_first_of("\r\n"), kMostExcuse));
  return line.empty() ? line : ": " + line;
}

class Connection : public WebSocket {
 public:
  /// `tls`: null for a plain connection.
  Connection(std::string place, const WebSocketOptions& options, asio::ssl::context* tls)
      : place_(std::move(place)),
        options_(options),
        stream_(ClientTransport::make(context_, tls)),
        timer_(context_) {}

  ~Connection() override {
    close();
    if (thread_.joinable()) thread_.join();
  }

  Result<void> open(const Url& url) {
    const std::stop_callback stopping(
        options_.stop, [this] { asio::post(context_, [this] { transport().close(); }); });
    const auto failed = [this](const std::string& what) {
      const bool stopped = options_.stop.stop_requested();
      return fail(stopped ? ErrorCode::cancelled : ErrorCode::io,
                  fmt::format("{}: {}", place_, what));
    };
    const auto begun = std::chrono::steady_clock::now();
    const auto found = look_up(url.host, url.port, options_.connect_timeout, options_.stop);
    if (!found) return failed(found.error().message);

    const auto deadline = begun + options_.connect_timeout;
    error_code error = run_until(deadline, [&](const auto& done) {
      asio::async_connect(transport().socket(), *found,
                          [done](error_code e, const auto&) { done(e); });
    });
    if (error) return failed("nothing answers there: " + error.message());
    set_options(transport().socket().native_handle());
    if (url.tls()) {
      error = run_until(
          deadline, [&](const auto& done) { transport().handshake(url.host, Completion(done)); });
      if (const std::string said = transport().distrust(); error && !said.empty()) {
        const auto [what, advice] = untrusted(said, options_.option_prefix + "ca-file");
        return fail(ErrorCode::refused, fmt::format("{}: {}; {}", place_, what, advice));
      }
      if (error.category() == asio::error::get_ssl_category())
        return failed("the TLS handshake failed (" + error.message() +
                      "); if the server does not use TLS, use ws://");
      if (error) return failed("TLS: " + error.message());
    }

    stream_.set_option(websocket::stream_base::decorator([this](websocket::request_type& request) {
      request.set(beast::http::field::user_agent, "pointreel");
      if (!options_.token.empty()) {
        request.set(beast::http::field::authorization, "Bearer " + options_.token);
      }
    }));
    websocket::response_type response;
    error = run_until(deadline, [&](const auto& done) {
      stream_.async_handshake(response, place_, url.target, done);
    });
    if (error == websocket::error::upgrade_declined) {
      const long status = response.result_int();
      return fail(code_of_status(status),
                  fmt::format("{}: answers {}{}", place_, status,
                              status == 401 ? ": it requires a valid token; give it with " +
                                                  options_.option_prefix + "token"
                                            : excuse(response.body())));
    }
    using HttpError = beast::http::error;
    if (error == HttpError::bad_version || error == HttpError::partial_message ||
        error == HttpError::end_of_stream || error == asio::error::connection_reset)
      return failed(std::string("there is no HTTP answer") +
                    (url.tls() ? "" : "; if the server uses TLS, use wss://"));
    if (error) return failed(error.message());
    websocket::stream_base::timeout timeout{};
    // timer_ limits the closing handshake. Beast's own timer would end a read that waits for the
    // handshake with an error that Beast does not expect there. It must be far off, not switched
    // off, or else the timer of the idle time before would go on.
    timeout.handshake_timeout = std::chrono::hours(1);
    // Connecting took at least two round trips. A slow link needs one of them for the answer to a
    // ping, which is sent after half of this time.
    timeout.idle_timeout = options_.silence_timeout + (std::chrono::steady_clock::now() - begun);
    timeout.keep_alive_pings = true;
    stream_.set_option(timeout);
    stream_.auto_fragment(false);
    stream_.write_buffer_bytes(kWriteBuffer);
    stream_.read_message_max(options_.max_message);
    stream_.control_callback([this](websocket::frame_type type, beast::string_view payload) {
      if (type == websocket::frame_type::pong) take_answer(payload);
    });
    return {};
  }

  void start() {
    read();
    thread_ = std::thread([this] {
      run();
      const std::lock_guard lock(mutex_);
      stopped_ = true;
      changed_.notify_all();
    });
  }

  Result<void> send(std::span<const ByteView> pieces, Kind kind) override {
    std::vector<asio::const_buffer> buffers;
    for (const ByteView piece : pieces) buffers.emplace_back(piece.data(), piece.size());
    bool done = false;
    error_code error;
    asio::post(context_, [&] {
      if (ended_) {
        finish(done, error, asio::error::not_connected);
        return;
      }
      stream_.binary(kind == Kind::binary);
      stream_.async_write(buffers, [&](error_code e, std::size_t) {
        if (!e) ++sent_;
        finish(done, error, e);  // `done` and `error` are gone after this
        ask();
      });
    });
    std::unique_lock lock(mutex_);
    // When the thread has stopped, no handler will run any more, so `done` may never be set.
    changed_.wait(lock, [&] { return done || stopped_; });
    if (done && !error) return {};
    return tl::unexpected(how_it_ended(error));
  }

  std::uint64_t confirmed() const override {
    const std::lock_guard lock(mutex_);
    return confirmed_;
  }

  Result<std::optional<WebSocketMessage>> receive(std::chrono::milliseconds timeout) override {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, timeout, [&] { return !inbox_.empty() || end_ || stopped_; });
    if (inbox_.empty()) {
      if (end_ || stopped_) return tl::unexpected(how_it_ended({}));
      return std::optional<WebSocketMessage>();
    }
    std::optional<WebSocketMessage> message = std::move(inbox_.front());
    inbox_.pop_front();
    const bool was_full = memory_ > options_.max_waiting;
    memory_ -= memory_of(*message);
    const bool read_on = paused_ && was_full && memory_ <= options_.max_waiting;
    if (read_on) paused_ = false;
    lock.unlock();
    if (read_on) asio::post(context_, [this] { read(); });
    return message;
  }

  std::size_t waiting() const override {
    const std::lock_guard lock(mutex_);
    return inbox_.size();
  }

  void close() override {
    asio::post(context_, [this] {
      if (ended_ || closed_) return;
      closed_ = true;
      timer_.expires_after(kCloseTime);
      // Closing the socket is not enough: it ends what waits for the socket, but the operations of
      // Beast can also wait for each other.
      timer_.async_wait([this](error_code error) {
        if (!error) end(asio::error::operation_aborted);
      });
      stream_.async_close(websocket::close_code::normal,
                          [this](error_code) { end(asio::error::operation_aborted); });
    });
  }

 private:
  /// Runs the pending operations to completion.
  void run() {
    context_.restart();
    context_.run();
  }

  /// Runs an operation to its end, or closes the socket at the deadline. begin(done) begins the
  /// operation, and done(error) must be called at its end.
  template <class Begin>
  error_code run_until(std::chrono::steady_clock::time_point deadline, const Begin& begin) {
    bool late = false;
    error_code result;
    timer_.expires_at(deadline);
    timer_.async_wait([&](error_code cancelled) {
      if (cancelled) return;
      late = true;
      transport().close();
    });
    begin([&](error_code error) {
      result = error;
      timer_.cancel();
    });
    run();
    return late ? beast::error::timeout : result;
  }

  ClientTransport& transport() { return stream_.next_layer().transport(); }

  void set_options(int socket) const {
    const int yes = 1;
    ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof(yes));
    ::setsockopt(socket, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentLimit, sizeof(kUnsentLimit));
    const auto stall = static_cast<unsigned>(options_.stall_timeout.count());
    if (stall > 0) ::setsockopt(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, &stall, sizeof(stall));
  }

  void finish(bool& done, error_code& result, error_code error) {
    const std::lock_guard lock(mutex_);
    done = true;
    result = error;
    changed_.notify_all();
  }

  /// Asks whether the peer has read what was sent, unless an answer is still awaited.
  void ask() {
    if (!options_.confirm || ended_ || closed_ || pinging_ || asked_ || sent_ == answered_) return;
    asked_ = sent_;
    pinging_ = true;
    stream_.async_ping(websocket::ping_data(std::to_string(sent_)), [this](error_code) {
      pinging_ = false;
      ask();
    });
  }

  void take_answer(beast::string_view payload) {
    if (!asked_ || payload != std::to_string(*asked_)) return;
    answered_ = *asked_;
    asked_.reset();
    {
      const std::lock_guard lock(mutex_);
      confirmed_ = answered_;
    }
    ask();
  }

  void read() {
    if (ended_) return;
    incoming_ = Bytes();
    incoming_.reserve(last_size_);
    buffer_.emplace(incoming_);
    stream_.async_read(*buffer_, [this](error_code error, std::size_t) {
      if (error) {
        end(error);
        return;
      }
      take();
    });
  }

  void take() {
    {
      const std::lock_guard lock(mutex_);
      last_size_ = incoming_.size();
      inbox_.push_back({stream_.got_binary() ? Kind::binary : Kind::text, std::move(incoming_)});
      memory_ += memory_of(inbox_.back());
      paused_ = memory_ > options_.max_waiting;
      changed_.notify_all();
      if (paused_) return;
    }
    read();
  }

  void end(error_code error) {
    if (ended_) return;
    ended_ = true;
    transport().close();
    // Otherwise the stream's own timer would keep the thread running for a while. Posted, so that
    // handlers that are ready run first.
    asio::post(context_, [this] { context_.stop(); });
    std::string how;
    ErrorCode code = ErrorCode::io;
    // A peer may tell its reason and then fail to end the connection properly, which is an error of
    // its own.
    if (error == websocket::error::closed || (!closed_ && stream_.reason())) {
      const auto reason = excuse(stream_.reason().reason.c_str());
      how = reason.empty() ? ": the server has closed the connection" : reason;
    } else if (error == beast::error::timeout) {
      how = ": the peer has fallen silent";
    } else if (error == websocket::error::message_too_big) {
      how = fmt::format(": sent a message of more than {} bytes", options_.max_message);
      code = ErrorCode::limit;
    } else if (error == asio::error::eof || error == asio::error::connection_reset) {
      how = ": the connection is lost";
    } else if (closed_) {
      how = ": the connection was closed";
      code = ErrorCode::cancelled;
    } else if (error == asio::error::bad_descriptor) {
      // Beast began to close the connection, did not see the peer do the same, and has lost the
      // reason.
      how = ": the peer broke the WebSocket protocol, or closed the connection improperly";
    } else {
      how = ": " + error.message();
    }
    const std::lock_guard lock(mutex_);
    end_ = Error{place_ + how, code};
    changed_.notify_all();
  }

  /// To be called with the lock held. `error`: that of the call that failed.
  Error how_it_ended(error_code error) const {
    if (end_) return *end_;
    if (error) return {fmt::format("{}: {}", place_, error.message()), ErrorCode::io};
    return {place_ + ": the connection was closed", ErrorCode::cancelled};
  }

  const std::string place_;
  const WebSocketOptions options_;
  asio::io_context context_{1};
  Stream stream_;
  Timer timer_;  ///< ends connecting, and later closing
  // Used by the connection's thread alone.
  Bytes incoming_;
  std::optional<asio::dynamic_vector_buffer<std::uint8_t, std::allocator<std::uint8_t>>> buffer_;
  std::size_t last_size_ = 0;
  bool ended_ = false, closed_ = false;
  std::uint64_t sent_ = 0, answered_ = 0;  ///< messages
  std::optional<std::uint64_t> asked_;     ///< the number in the ping that awaits its answer
  bool pinging_ = false;                   ///< it is being sent

  mutable std::mutex mutex_;  ///< guards the members below
  std::uint64_t confirmed_ = 0;
  std::condition_variable changed_;
  std::deque<WebSocketMessage> inbox_;
  std::size_t memory_ = 0;  ///< of the messages in it
  bool paused_ = false, stopped_ = false;
  std::optional<Error> end_;  ///< why the connection has ended
  std::thread thread_;
};

Result<asio::ssl::context> client_context(const WebSocketOptions& options) {
  asio::ssl::context tls(asio::ssl::context::tls_client);
  ::SSL_CTX_set_min_proto_version(tls.native_handle(), TLS1_2_VERSION);
  error_code error;
  if (options.ca_file.empty()) {
    tls.set_default_verify_paths(error);
  } else {
    tls.load_verify_file(options.ca_file, error);
  }
  if (error) return fail(ErrorCode::argument, fault_of_certificates(options.ca_file));
  return tls;
}

}  // namespace

Result<Url> parse_websocket_url(const std::string& text) {
  Url url = TRY(parse_url(text));
  if (!url.is_websocket())
    return fail(ErrorCode::argument,
                without_secrets(text) + ": does not begin with ws:// or wss://");
  if (!url.user.empty())
    return fail(ErrorCode::argument,
                without_secrets(text) + ": names a user; give a token instead");
  return url;
}

Result<void> check_websocket(const std::string& text, const WebSocketOptions& options) {
  if (TRY(parse_websocket_url(text)).tls()) TRY(client_context(options));
  return {};
}

Result<std::unique_ptr<WebSocket>> WebSocket::connect(const std::string& text,
                                                      const WebSocketOptions& options) try {
  const Url url = TRY(parse_websocket_url(text));
  std::optional<asio::ssl::context> tls;
  if (url.tls()) tls = TRY(client_context(options));
  auto connection = std::make_unique<Connection>(url.place(), options, tls ? &*tls : nullptr);
  TRY(connection->open(url));
  connection->start();
  return connection;
} catch (const std::exception& error) {
  return fail(ErrorCode::io, fmt::format("{}: {}", text, error.what()));
}

}  // namespace pointreel
