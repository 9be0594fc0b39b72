#include "server/serve/http_server.h"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <fmt/format.h>

#include "common/base/try.h"
#include "server/serve/asio_types.h"
#include "server/serve/connection.h"
#include "server/serve/tls.h"
#include "server/serve/transport.h"
#include "server/service/connection_table.h"

namespace pointreel {
namespace {

/// How many connections get a response that there is no room, at a time. More are closed at once.
constexpr std::size_t kMaxRefusals = 64;
constexpr std::chrono::milliseconds kAcceptPause{100};
/// Between two log lines that say that there is no room.
constexpr std::chrono::seconds kWarningPause{10};

ServiceOptions service_options(const HttpServerOptions& options) {
  ServiceOptions service = options.service;
  service.loopback = is_loopback(options.listen);
  return service;
}

/// Adds one to a counter while it lives.
class Count {
 public:
  explicit Count(std::atomic<std::size_t>& count) : count_(&count) { ++*count_; }
  Count(Count&& other) noexcept : count_(std::exchange(other.count_, nullptr)) {}
  Count& operator=(Count&&) = delete;
  ~Count() {
    if (count_ != nullptr) --*count_;
  }

 private:
  std::atomic<std::size_t>* count_;
};

}  // namespace

struct HttpServer::State {
  State(Catalog catalog, const HttpServerOptions& wanted, Relay* relay)
      : options(wanted),
        service(std::move(catalog), relay, service_options(wanted), wanted),
        table(wanted.max_connections, wanted.max_connections_per_address) {
    service.watch(table);
  }

  Task<void> accept();
  void admit(Socket socket);
  void refuse(std::shared_ptr<Transport> transport, const Peer& peer,
              ConnectionTable::Refusal refusal);
  /// Null if there is no memory for TLS.
  std::unique_ptr<Transport> transport_on(Socket socket);
  void watch(const std::shared_ptr<Transport>& transport) {
    asio::co_spawn(transport->executor(), Transport::watch(transport), asio::detached);
  }

  HttpServerOptions options;
  Service service;
  std::mutex tls_mutex;
  std::shared_ptr<const TlsContext> tls;  ///< guarded by it; null: plain HTTP
  ListenAddress address;
  ConnectionTable table;
  std::atomic<std::size_t> refusals{0};
  Clock::time_point
      warned{};  ///< when a refused connection was last logged; acceptor's strand only
  // Destroying the context ends the coroutines, which closes their sockets.
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
    // No descriptors or no memory: what is waiting must wait until other connections have ended.
    pause.expires_after(kAcceptPause);
    co_await pause.async_wait(asio::redirect_error(kUseAwaitable, error));
  }
}

std::unique_ptr<Transport> HttpServer::State::transport_on(Socket socket) {
  std::unique_ptr<TlsSession> session;
  std::shared_ptr<const TlsContext> present;
  {
    const std::lock_guard lock(tls_mutex);
    present = tls;
  }
  if (present && !(session = present->session(socket.native_handle()))) return nullptr;
  return std::make_unique<Transport>(std::move(socket), std::move(session), options.header_timeout,
                                     options.stall_timeout);
}

void HttpServer::State::admit(Socket socket) {
  error_code error;
  const auto endpoint = socket.remote_endpoint(error);
  if (error) return;  // gone already
  const asio::ip::address& from = endpoint.address();
  Peer peer = peer_of(
      (from.is_v4() ? asio::ip::make_address_v6(asio::ip::v4_mapped, from.to_v4()) : from.to_v6())
          .to_bytes());
  auto transport = transport_on(std::move(socket));
  if (!transport) return;
  struct Admitted {  // the place is destroyed after the transport
    std::optional<ConnectionTable::Place> place;
    std::unique_ptr<Transport> transport;
  };
  const auto admitted = std::make_shared<Admitted>();
  admitted->transport = std::move(transport);
  const std::shared_ptr<Transport> shared(admitted, admitted->transport.get());
  auto place = table.admit(peer, [executor = shared->executor(), weak = std::weak_ptr(shared)] {
    asio::post(executor, [weak] {
      if (const auto idle = weak.lock()) idle->close();
    });
  });
  if (!place) return refuse(shared, peer, place.error());
  admitted->place.emplace(*std::move(place));
  ++service.metrics().connections;
  // Both run on the strand from their first step on.
  watch(shared);
  asio::co_spawn(shared->executor(),
                 serve_connection(shared, *admitted->place, std::move(peer), service, options),
                 asio::detached);
}

void HttpServer::State::refuse(std::shared_ptr<Transport> transport, const Peer& peer,
                               ConnectionTable::Refusal refusal) {
  const bool full = refusal == ConnectionTable::Refusal::kFull;
  ++(full ? service.metrics().refused_full : service.metrics().refused_address);
  if (const auto now = Clock::now(); now >= warned + kWarningPause) {
    warned = now;
    service.log().write(
        Log::Level::kWarning, full ? "connections.full" : "connections.address",
        {{"peer", peer.address}, {"open", static_cast<std::int64_t>(table.count())}});
  }
  if (refusals >= kMaxRefusals) return;
  struct Refused {
    Count count;
    std::shared_ptr<Transport> transport;
  };
  const auto refused = std::make_shared<Refused>(Count(refusals), std::move(transport));
  const std::shared_ptr<Transport> shared(refused, refused->transport.get());
  watch(shared);
  asio::co_spawn(shared->executor(), refuse_connection(shared, refusal), asio::detached);
}

HttpServer::HttpServer(std::unique_ptr<State> state) : state_(std::move(state)) {}

HttpServer::~HttpServer() { stop(); }

const ListenAddress& HttpServer::address() const { return state_->address; }

std::size_t HttpServer::connection_count() const { return state_->table.count(); }

Result<std::unique_ptr<HttpServer>> HttpServer::start(Catalog catalog,
                                                      const HttpServerOptions& options,
                                                      Relay* relay) try {
  auto state = std::make_unique<State>(std::move(catalog), options, relay);
  if (!options.certificate.empty()) {
    state->tls =
        std::make_shared<const TlsContext>(TRY(TlsContext::load(options.certificate, options.key)));
  }
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
  // From here on the destructor of the server ends what has been started.
  std::unique_ptr<HttpServer> server(new HttpServer(std::move(state)));
  for (unsigned i = 0; i < threads; ++i) {
    server->state_->threads.emplace_back([&context = *server->state_->context] {
      // sendfile to a peer that has gone raises SIGPIPE in the calling thread.
      sigset_t signals;
      sigemptyset(&signals);
      sigaddset(&signals, SIGPIPE);
      ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
      while (!context.stopped()) {
        try {
          context.run();
        } catch (const std::exception&) {
          // Out of memory: this ends one operation, but not the server.
        }
      }
    });
  }
  return server;
} catch (const boost::system::system_error& error) {
  return fail(ErrorCode::io, fmt::format("cannot listen on {}: {}; choose another with --listen",
                                         to_string(options.listen), error.code().message()));
} catch (const std::exception& error) {
  return fail(ErrorCode::io, fmt::format("cannot start the server: {}", error.what()));
}

Result<void> HttpServer::read_certificate(const std::filesystem::path& certificate,
                                          const std::filesystem::path& key) {
  if (certificate.empty() != state_->options.certificate.empty())
    return fail(ErrorCode::argument, "--certificate: only a restart turns TLS on or off");
  if (certificate.empty()) return {};
  for (const std::filesystem::path& path : {certificate, key}) {
    std::error_code error;  // of a file that is not there: load() says so
    if (std::filesystem::is_fifo(path, error))
      return fail(ErrorCode::io, path.string() + ": is a pipe, which is read at the start alone");
  }
  auto tls = std::make_shared<const TlsContext>(TRY(TlsContext::load(certificate, key)));
  const std::lock_guard lock(state_->tls_mutex);
  state_->tls.swap(tls);
  return {};
}

void HttpServer::set_tokens(std::string_view view_token, std::string_view publish_token) {
  state_->service.set_tokens(view_token, publish_token);
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
