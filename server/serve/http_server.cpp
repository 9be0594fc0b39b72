#include "server/serve/http_server.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <ctime>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <fmt/format.h>
#include <netinet/tcp.h>
#include <sys/sendfile.h>
#include <sys/socket.h>

#include "server/serve/responder.h"

namespace pointreel {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kHeaderLimit = 8 * 1024;
/// Of a file, between two looks at what else there is to do.
constexpr std::uint64_t kPieceSize = 256 * 1024;
/// Bytes that the kernel may hold for a connection beyond what is in flight.
constexpr int kUnsentLimit = 256 * 1024;
/// Connections that are being told that the table is full. Beyond it they are closed unheard.
constexpr std::size_t kMaxRefusals = 64;
constexpr std::chrono::milliseconds kAcceptPause{100};
/// What a peer may still send, and for how long, after an error's response: closing a socket with
/// unread bytes resets the connection, and the response would be lost with it.
constexpr std::size_t kLingerBytes = 64 * 1024;
constexpr std::chrono::milliseconds kLingerTime{1000};

// One strand for each connection. The executors' types are spelt out, for the defaults' erase them
// and pay for it on every operation.
using Strand = asio::strand<asio::io_context::executor_type>;
using Socket = asio::basic_stream_socket<asio::ip::tcp, Strand>;
using Acceptor = asio::basic_socket_acceptor<asio::ip::tcp, Strand>;
using Timer = asio::basic_waitable_timer<Clock, asio::wait_traits<Clock>, Strand>;
template <class T>
using Task = asio::awaitable<T, Strand>;
constexpr asio::use_awaitable_t<Strand> kUseAwaitable{};

struct Limits {
  std::chrono::milliseconds header, idle, stall;
};

std::int64_t unix_time() { return static_cast<std::int64_t>(std::time(nullptr)); }

/// A count that is given back when the owner ends.
class Place {
 public:
  explicit Place(std::atomic<std::size_t>& count) : count_(&count) { ++*count_; }
  Place(Place&& other) noexcept : count_(std::exchange(other.count_, nullptr)) {}
  Place& operator=(Place&&) = delete;
  ~Place() {
    if (count_ != nullptr) --*count_;
  }

 private:
  std::atomic<std::size_t>* count_;
};

/// A socket and the time by which something must have happened on it. All of it runs on the
/// socket's strand.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Socket socket, Place place, const Limits& limits)
      : socket_(std::move(socket)),
        timer_(socket_.get_executor()),
        place_(std::move(place)),
        limits_(limits) {
    error_code ignored;
    socket_.native_non_blocking(true, ignored);
    socket_.set_option(asio::ip::tcp::no_delay(true), ignored);
    ::setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentLimit,
                 sizeof(kUnsentLimit));
    set_deadline(limits.header);
  }

  Strand executor() { return socket_.get_executor(); }

  /// Closes the socket when a deadline passes. One timer that is looked at when it ends, instead
  /// of one armed for each operation: deadlines nearly always move to later times.
  static Task<void> watch(std::shared_ptr<Connection> self) {
    while (self->socket_.is_open()) {
      if (Clock::now() >= self->deadline_) {
        self->close();
        break;
      }
      self->timer_.expires_at(self->deadline_);
      error_code ignored;
      co_await self->timer_.async_wait(asio::redirect_error(kUseAwaitable, ignored));
    }
  }

  /// Answers requests until the peer ends, errs or stalls.
  static Task<void> serve(std::shared_ptr<Connection> self, const Catalog& catalog) {
    beast::flat_buffer buffer(2 * kHeaderLimit);
    while (true) {
      http::request_parser<http::empty_body> parser;
      parser.header_limit(kHeaderLimit);
      error_code error;
      if (!co_await self->read_head(buffer, parser, error)) break;
      Response response = error ? refusal(error) : respond(catalog, request_of(parser.get()));
      const bool keep_alive = !error && !response.close && parser.get().keep_alive();
      if (!co_await self->write(response, keep_alive)) break;
      if (!keep_alive) {
        co_await self->linger();
        break;
      }
      self->set_deadline(self->limits_.idle);
    }
    self->close();
  }

  /// Tells a connection that there is no room for it.
  static Task<void> refuse(std::shared_ptr<Connection> self) {
    const Response response =
        error_response(503, "too many connections; try again", "Retry-After: 1\r\n");
    self->set_deadline(kLingerTime);
    if (co_await self->write(response, false)) co_await self->linger();
    self->close();
  }

 private:
  void set_deadline(Clock::duration from_now) {
    deadline_ = Clock::now() + from_now;
    if (deadline_ < timer_.expiry()) timer_.cancel();
  }

  void close() {
    error_code ignored;
    socket_.close(ignored);
    timer_.cancel();
  }

  /// Reads one request's head. False if the connection ended; `error` if it is no HTTP.
  Task<bool> read_head(beast::flat_buffer& buffer, http::request_parser<http::empty_body>& parser,
                       error_code& error) {
    bool started = false;
    while (true) {
      if (buffer.size() > 0) {
        if (!started) {
          started = true;
          set_deadline(limits_.header);
        }
        buffer.consume(parser.put(buffer.data(), error));
        if (error == http::error::need_more) error = {};
        if (error || parser.is_header_done()) co_return true;
      }
      if (buffer.size() >= kHeaderLimit) {
        error = http::error::header_limit;
        co_return true;
      }
      error_code read_error;
      const std::size_t size =
          co_await socket_.async_read_some(buffer.prepare(kHeaderLimit - buffer.size()),
                                           asio::redirect_error(kUseAwaitable, read_error));
      if (read_error) co_return false;
      buffer.commit(size);
    }
  }

  static Response refusal(error_code error) {
    if (error == http::error::header_limit || error == http::error::buffer_overflow) {
      return error_response(
          431, fmt::format("the head of a request may have at most {} bytes", kHeaderLimit));
    }
    if (error == http::error::bad_version) return error_response(505, "HTTP/1.1 is spoken here");
    return error_response(400, "this is no HTTP/1.1 request");
  }

  static Request request_of(const http::request<http::empty_body>& message) {
    const auto joined = [&message](http::field name) {
      std::string value;
      const auto [begin, end] = message.equal_range(name);
      for (auto field = begin; field != end; ++field) {
        if (!value.empty()) value += ", ";
        value.append(field->value().data(), field->value().size());
      }
      return value;
    };
    Request request;
    request.method = {message.method_string().data(), message.method_string().size()};
    request.target = {message.target().data(), message.target().size()};
    request.range = joined(http::field::range);
    request.if_range = joined(http::field::if_range);
    request.if_match = joined(http::field::if_match);
    request.if_none_match = joined(http::field::if_none_match);
    request.host_fields = static_cast<int>(message.count(http::field::host));
    request.http_1_0 = message.version() < 11;
    const std::string length = joined(http::field::content_length);
    request.has_body = message.chunked() || (!length.empty() && length != "0");
    return request;
  }

  /// Waits until the socket takes bytes. False if the connection ended.
  Task<bool> writable() {
    error_code error;
    co_await socket_.async_wait(Socket::wait_write, asio::redirect_error(kUseAwaitable, error));
    co_return !error;
  }

  Task<bool> write(const Response& response, bool keep_alive) {
    const std::string head = write_head(response, keep_alive, unix_time());
    set_deadline(limits_.stall);
    if (response.file.get() < 0) {
      const std::string_view body =
          response.error_text.empty() ? response.text : std::string_view(response.error_text);
      // The head waits for the body in the kernel, so that both leave in one packet.
      if (!co_await write_text(head, body.empty() ? 0 : MSG_MORE)) co_return false;
      co_return body.empty() || co_await write_text(body, 0);
    }
    if (!co_await write_text(head, response.size == 0 ? 0 : MSG_MORE)) co_return false;
    co_return co_await write_file(response.file.get(), response.offset, response.size);
  }

  Task<bool> write_text(std::string_view text, int flags) {
    while (!text.empty()) {
      const ssize_t sent =
          ::send(socket_.native_handle(), text.data(),
                 std::min<std::size_t>(text.size(), kPieceSize), flags | MSG_NOSIGNAL);
      if (sent > 0) {
        text.remove_prefix(static_cast<std::size_t>(sent));
        set_deadline(limits_.stall);
        continue;
      }
      if (errno == EINTR) continue;
      if (errno != EAGAIN || !co_await writable()) co_return false;
    }
    co_return true;
  }

  Task<bool> write_file(int file, std::uint64_t offset, std::uint64_t size) {
    off_t at = static_cast<off_t>(offset);
    while (size > 0) {
      const ssize_t sent = ::sendfile(socket_.native_handle(), file, &at,
                                      static_cast<std::size_t>(std::min(size, kPieceSize)));
      if (sent > 0) {
        size -= static_cast<std::uint64_t>(sent);
        set_deadline(limits_.stall);
        // A reader as fast as the disk must not keep a thread from everybody else.
        if (size > 0) co_await asio::post(socket_.get_executor(), kUseAwaitable);
        if (!socket_.is_open()) co_return false;
        continue;
      }
      if (sent == 0) co_return false;  // the file shrank: too late for anything but a short answer
      if (errno == EINTR) continue;
      if (errno != EAGAIN || !co_await writable()) co_return false;
    }
    co_return true;
  }

  Task<void> linger() {
    error_code error;
    socket_.shutdown(Socket::shutdown_send, error);
    set_deadline(kLingerTime);
    std::array<char, 4096> unread;
    for (std::size_t total = 0; !error && total < kLingerBytes;) {
      total += co_await socket_.async_read_some(asio::buffer(unread),
                                                asio::redirect_error(kUseAwaitable, error));
    }
  }

  Socket socket_;
  Timer timer_;
  Clock::time_point deadline_{};
  Place place_;
  Limits limits_;
};

}  // namespace

struct HttpServer::State {
  State(Catalog served, const HttpServerOptions& wanted)
      : catalog(std::move(served)), options(wanted) {}

  Task<void> accept();
  void admit(Socket socket);

  Catalog catalog;
  HttpServerOptions options;
  ListenAddress address;
  std::atomic<std::size_t> connections{0}, refusals{0};
  // Its end ends the coroutines and so closes their sockets.
  std::optional<asio::io_context> context{std::in_place};
  std::optional<Acceptor> acceptor{asio::make_strand(*context)};
  std::vector<std::thread> threads;
};

Task<void> HttpServer::State::accept() {
  Timer pause(acceptor->get_executor());
  while (true) {
    error_code error;
    try {
      Socket socket = co_await acceptor->async_accept(asio::make_strand(*context),
                                                      asio::redirect_error(kUseAwaitable, error));
      if (!error) admit(std::move(socket));
    } catch (const std::bad_alloc&) {
      error = asio::error::no_memory;
    }
    if (!error || error == asio::error::connection_aborted) continue;
    // No descriptors or memory: what is waiting waits on until others have ended.
    pause.expires_after(kAcceptPause);
    co_await pause.async_wait(asio::redirect_error(kUseAwaitable, error));
  }
}

void HttpServer::State::admit(Socket socket) {
  const Limits limits{options.header_timeout, options.idle_timeout, options.stall_timeout};
  const bool full = connections >= options.max_connections;
  if (full && refusals >= kMaxRefusals) return;
  auto connection =
      std::make_shared<Connection>(std::move(socket), Place(full ? refusals : connections), limits);
  const Strand executor = connection->executor();
  // Both on the strand from their first step on.
  asio::co_spawn(executor, Connection::watch(connection), asio::detached);
  if (full) {
    asio::co_spawn(executor, Connection::refuse(std::move(connection)), asio::detached);
  } else {
    asio::co_spawn(executor, Connection::serve(std::move(connection), catalog), asio::detached);
  }
}

HttpServer::HttpServer(std::unique_ptr<State> state) : state_(std::move(state)) {}

HttpServer::~HttpServer() { stop(); }

const ListenAddress& HttpServer::address() const { return state_->address; }

std::size_t HttpServer::connection_count() const { return state_->connections; }

Result<std::unique_ptr<HttpServer>> HttpServer::start(Catalog catalog,
                                                      const HttpServerOptions& options) try {
  auto state = std::make_unique<State>(std::move(catalog), options);
  const asio::ip::tcp::endpoint endpoint(asio::ip::make_address(options.listen.host),
                                         options.listen.port);
  Acceptor& acceptor = *state->acceptor;
  acceptor.open(endpoint.protocol());
  acceptor.set_option(asio::socket_base::reuse_address(true));
  acceptor.bind(endpoint);
  acceptor.listen();
  state->address = {options.listen.host, acceptor.local_endpoint().port()};

  asio::co_spawn(acceptor.get_executor(), state->accept(), asio::detached);
  const unsigned threads =
      options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  // From here on the destructor of the server ends what has begun.
  std::unique_ptr<HttpServer> server(new HttpServer(std::move(state)));
  for (unsigned i = 0; i < threads; ++i) {
    server->state_->threads.emplace_back([&context = *server->state_->context] {
      // sendfile to a peer that is gone raises it in the calling thread.
      sigset_t signals;
      sigemptyset(&signals);
      sigaddset(&signals, SIGPIPE);
      ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
      while (!context.stopped()) {
        try {
          context.run();
        } catch (const std::exception&) {  // out of memory: one operation is lost, not the server
        }
      }
    });
  }
  return server;
} catch (const boost::system::system_error& error) {
  return fail(fmt::format("cannot listen on {}: {}; choose another with --listen",
                          to_string(options.listen), error.code().message()));
} catch (const std::exception& error) {
  return fail(fmt::format("cannot start the server: {}", error.what()));
}

void HttpServer::stop() {
  if (!state_->context) return;
  state_->context->stop();
  for (std::thread& thread : state_->threads) thread.join();
  state_->threads.clear();
  state_->acceptor.reset();
  state_->context.reset();
}

}  // namespace pointreel
