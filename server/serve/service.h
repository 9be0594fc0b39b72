#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <variant>

#include "server/relay/relay.h"
#include "server/serve/access.h"
#include "server/serve/catalog.h"
#include "server/serve/connection_table.h"
#include "server/serve/log.h"
#include "server/serve/metrics.h"
#include "server/serve/peer.h"
#include "server/serve/rate_limiter.h"
#include "server/serve/responder.h"

/// All that the server does, without a socket: who may have what, and what the answer is.
namespace pointreel {

struct ServiceOptions {
  std::string view_token, publish_token;  ///< empty: none is needed, see Access
  Log::Level log = Log::Level::kWarning;
};

/// A request that goes on as a WebSocket.
struct LiveCall {
  std::string stream;
  std::unique_ptr<Publication> publication;  ///< it publishes; or
  std::unique_ptr<Viewer> viewer;            ///< it views
};

class Service {
 public:
  /// `relay` may be null: there are no live streams. Else it must outlive the service.
  Service(Catalog catalog, Relay* relay, const ServiceOptions& options,
          double requests_per_second = 0);

  /// Safe from any thread. `wake` is for a viewer, see Relay::join.
  std::variant<Response, LiveCall> answer(const Request& request, const Peer& peer,
                                          std::function<void()> wake = {});
  /// The answer to what is no request.
  Response refuse(Response refusal);

  Metrics& metrics() { return metrics_; }
  Log& log() { return log_; }
  Relay* relay() { return relay_; }
  /// What /metrics says of connections comes from here; set before the first answer.
  void watch(const ConnectionTable& table) { table_ = &table; }

 private:
  std::variant<Response, LiveCall> decide(const Request& request, const Peer& peer,
                                          std::function<void()> wake);
  std::variant<Response, LiveCall> live_call(const Request& request, const Peer& peer,
                                             std::string stream, std::function<void()> wake);
  Response metrics_page() const;

  Catalog catalog_;
  Relay* relay_;
  Access access_;
  RateLimiter rate_;
  const ConnectionTable* table_ = nullptr;
  Log log_;
  Metrics metrics_;
};

}  // namespace pointreel
