#include "server/serve/http_server.h"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <new>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/redirect_error.hpp>
#include <fmt/format.h>

#include "server/serve/asio_types.h"
#include "server/serve/connection.h"
#include "server/serve/tls.h"
#include "server/serve/transport.h"

namespace pointreel {
namespace {

/// Connections that are being told that the table is full. Beyond it they are closed unheard.
constexpr std::size_t kMaxRefusals = 64;
constexpr std::chrono::milliseconds kAcceptPause{100};

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

}  // namespace

struct HttpServer::State {
  State(Catalog catalog, const HttpServerOptions& wanted, Relay* relay)
      : options(wanted), service(std::move(catalog), relay, wanted.service) {
    service.open_connections = [this] { return connections.load(); };
  }

  Task<void> accept();
  void admit(Socket socket);

  HttpServerOptions options;
  Service service;
  std::optional<TlsContext> tls;
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
  error_code error;
  const auto endpoint = socket.remote_endpoint(error);
  if (error) return;  // gone already
  const asio::ip::address& from = endpoint.address();
  Peer peer = peer_of(
      (from.is_v4() ? asio::ip::make_address_v6(asio::ip::v4_mapped, from.to_v4()) : from.to_v6())
          .to_bytes());
  const bool full = connections >= options.max_connections;
  ++(full ? service.metrics().refused_full : service.metrics().connections);
  if (full && refusals >= kMaxRefusals) return;
  std::unique_ptr<TlsSession> session;
  if (tls && !(session = tls->session(socket.native_handle()))) return;
  struct Placed {  // what is declared first ends last
    Place place;
    Transport transport;
  };
  const auto placed =
      std::make_shared<Placed>(Place(full ? refusals : connections),
                               Transport(std::move(socket), std::move(session),
                                         options.header_timeout, options.stall_timeout));
  const std::shared_ptr<Transport> transport(placed, &placed->transport);
  // Both on the strand from their first step on.
  asio::co_spawn(transport->executor(), Transport::watch(transport), asio::detached);
  asio::co_spawn(transport->executor(),
                 full ? refuse_connection(transport)
                      : serve_connection(transport, std::move(peer), service, options),
                 asio::detached);
}

HttpServer::HttpServer(std::unique_ptr<State> state) : state_(std::move(state)) {}

HttpServer::~HttpServer() { stop(); }

const ListenAddress& HttpServer::address() const { return state_->address; }

std::size_t HttpServer::connection_count() const { return state_->connections; }

Result<std::unique_ptr<HttpServer>> HttpServer::start(Catalog catalog,
                                                      const HttpServerOptions& options,
                                                      Relay* relay) try {
  auto state = std::make_unique<State>(std::move(catalog), options, relay);
  if (!options.certificate.empty()) {
    auto tls = TlsContext::load(options.certificate, options.key);
    if (!tls) return tl::unexpected(tls.error());
    state->tls = *std::move(tls);
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
