#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <variant>

#include "server/relay/relay.h"
#include "server/service/access.h"
#include "server/service/catalog.h"
#include "server/service/connection_table.h"
#include "server/service/limits.h"
#include "server/service/log.h"
#include "server/service/metrics.h"
#include "server/service/origin.h"
#include "server/service/page.h"
#include "server/service/peer.h"
#include "server/service/peer_quota.h"
#include "server/service/rate_limiter.h"
#include "server/service/responder.h"

/// Everything that the server does except for sockets: decides who may do what, and answers
/// requests.
namespace pointreel {

struct ServiceOptions {
  std::string view_token, publish_token;  ///< as Access takes them
  bool loopback = false;  ///< the server listens on loopback alone; HttpServer sets this
  /// Without a publish token, connections from loopback may publish even if the server listens on
  /// other addresses too: whoever sets this knows that no proxy on this machine forwards others.
  bool allow_local_publish = false;
  Origins origins;
  Page page;  ///< what browsers get; empty: the same as programs
  Log::Level log = Log::Level::kWarning;
};

/// The WebSocket subprotocol of live streams. Pages in browsers offer it, since only next to it can
/// they send a token: "pointreel, bearer.TOKEN". Programs need not.
inline constexpr std::string_view kLiveProtocol = "pointreel";

/// A request that is upgraded to a WebSocket: either a publication or a viewer.
struct LiveCall {
  std::string stream;  ///< empty: the list of all streams, for a viewer
  std::unique_ptr<Publication> publication;
  std::unique_ptr<Viewer> viewer;
  PeerQuota::Share hello;  ///< until the publisher has said hello
  bool protocol = false;   ///< the answer says that it is kLiveProtocol
};

class Service {
 public:
  /// `relay` must outlive the service; null: no live streams.
  Service(Catalog catalog, Relay* relay, const ServiceOptions& options, const Limits& limits = {});

  /// Answers a request. From any thread. `wake` is for viewers, as in Relay::join.
  std::variant<Response, LiveCall> answer(const Request& request, const Peer& peer,
                                          std::function<void()> wake = {});
  /// Answers something that is not a valid request.
  Response refuse(Response refusal);

  /// Replaces the tokens, for all requests from now on. From any thread.
  void set_tokens(std::string_view view_token, std::string_view publish_token);

  Metrics& metrics() { return metrics_; }
  Log& log() { return log_; }
  Relay* relay() { return relay_; }
  /// The messages of publishers that are not complete.
  PeerQuota& unfinished() { return unfinished_; }
  /// Sets the table whose connections /metrics reports. Call this before the first answer.
  void watch(const ConnectionTable& table) { table_ = &table; }

 private:
  std::variant<Response, LiveCall> decide(const Request& request, const Peer& peer,
                                          std::function<void()> wake);
  std::variant<Response, LiveCall> live_call(const Request& request, const Peer& peer,
                                             std::string stream, std::function<void()> wake);
  /// What a browser gets at this path instead of what programs get; null if that is the same.
  std::shared_ptr<const Resource> page_at(const std::string& path, const Request& request) const;
  /// Whether browsers get the page at this path: that of the list, of a reel, or of a live stream.
  bool has_page(std::string_view path) const;
  Response metrics_page() const;
  std::shared_ptr<const Resource> list() const;

  Catalog catalog_;
  Relay* relay_;
  std::shared_ptr<const Access> access() const;
  mutable std::mutex access_mutex_;
  std::shared_ptr<const Access> access_;
  const bool loopback_, local_publish_;
  const Origins origins_;
  const Page page_;
  RateLimiter rate_;
  PeerQuota hellos_, unfinished_;
  const ConnectionTable* table_ = nullptr;
  Log log_;
  Metrics metrics_;
};

}  // namespace pointreel
