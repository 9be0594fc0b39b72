#include "server/service/service.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "server/service/negotiation.h"
#include "server/service/request_target.h"

namespace pointreel {
namespace {

constexpr std::string_view kLivePath = "/live/", kLiveList = "/live";
constexpr std::string_view kManifestEnd = "/reel.json";

/// Whether the query of a request target has this parameter, with or without a value.
bool query_has(std::string_view target, std::string_view name) {
  const auto begin = target.find('?');
  if (begin == std::string_view::npos) return false;
  for (std::string_view rest = target.substr(begin + 1); !rest.empty();) {
    const auto end = std::min(rest.find('&'), rest.size());
    const std::string_view pair = rest.substr(0, end);
    if (pair.substr(0, pair.find('=')) == name) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

/// If viewers need a token, shared caches must not keep what they get.
void make_private(Response& response) {
  constexpr std::string_view kPublic = "Cache-Control: public,";
  if (const auto at = response.fields.find(kPublic); at != std::string::npos) {
    response.fields.replace(at, kPublic.size(), "Cache-Control: private,");
  }
}

Response token_wanted() {
  return error_response(401, "a valid token is required: Authorization: Bearer TOKEN",
                        "WWW-Authenticate: Bearer realm=\"pointreel\"\r\n");
}

/// The credentials of a request for a live stream: a browser cannot set Authorization there, and
/// sends the token, percent-encoded, as a subprotocol. In the address it would be logged.
std::string live_credentials(const Request& request) {
  if (!request.authorization.empty()) return request.authorization;
  constexpr std::string_view kBearer = "bearer.";
  std::string_view rest = request.protocols;
  while (!rest.empty()) {
    const auto end = std::min(rest.find(','), rest.size());
    std::string_view item = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    while (item.starts_with(' ') || item.starts_with('\t')) item.remove_prefix(1);
    while (item.ends_with(' ') || item.ends_with('\t')) item.remove_suffix(1);
    if (!item.starts_with(kBearer)) continue;
    const auto token = decode_escapes(item.substr(kBearer.size()));
    return token ? fmt::format("Bearer {}", *token) : std::string();
  }
  return {};
}

}  // namespace

Service::Service(Catalog catalog, Relay* relay, const ServiceOptions& options, const Limits& limits)
    : catalog_(std::move(catalog)),
      relay_(relay),
      access_(std::make_shared<const Access>(options.view_token, options.publish_token)),
      loopback_(options.loopback),
      local_publish_(options.loopback || options.allow_local_publish),
      origins_(options.origins),
      page_(options.page),
      rate_(limits.requests_per_second),
      hellos_(limits.max_hellos, limits.max_hellos_per_address),
      unfinished_(limits.max_unfinished, limits.max_unfinished_per_address),
      log_(options.log) {}

void Service::set_tokens(std::string_view view_token, std::string_view publish_token) {
  auto access = std::make_shared<const Access>(view_token, publish_token);
  const std::lock_guard lock(access_mutex_);
  access_.swap(access);
}

std::shared_ptr<const Access> Service::access() const {
  const std::lock_guard lock(access_mutex_);
  return access_;
}

std::variant<Response, LiveCall> Service::answer(const Request& request, const Peer& peer,
                                                 std::function<void()> wake) {
  auto decided = decide(request, peer, std::move(wake));
  if (auto* response = std::get_if<Response>(&decided)) {
    finish_response(*response, request);
    response->fields += origins_.fields(request.origin, request.method == "OPTIONS");
    metrics_.count_response(response->status);
  }
  return decided;
}

std::variant<Response, LiveCall> Service::decide(const Request& request, const Peer& peer,
                                                 std::function<void()> wake) {
  if (rate_.limits() && !rate_.allow(peer.network, RateLimiter::Clock::now())) {
    metrics_.limited_requests.fetch_add(1, std::memory_order_relaxed);
    return error_response(429, "too many requests; wait a second", "Retry-After: 1\r\n");
  }
  auto path = path_of(request);
  if (!path) return std::move(path.error());
  if (*path == "/healthz") return respond(catalog_.find(*path), request);
  if (loopback_ && request.host_fields > 0 && !origins_.answers_on_loopback_for(request.host)) {
    return error_response(421,
                          "this server is on loopback and does not answer for this host; start it "
                          "with --allow-origin http://HOST to let it");
  }
  if (request.websocket && relay_ != nullptr && *path == kLiveList)
    return live_call(request, peer, {}, std::move(wake));
  if (request.websocket && relay_ != nullptr && path->starts_with(kLivePath) &&
      is_stream_name(std::string_view(*path).substr(kLivePath.size()))) {
    return live_call(request, peer, path->substr(kLivePath.size()), std::move(wake));
  }
  // The page is no secret, and a browser can send no token with a link. The page asks for one.
  if (auto page = page_at(*path, request)) return respond(std::move(page), request);
  if (access()->check(Access::Right::kView, request.authorization, false) !=
      Access::Verdict::kGranted) {
    return token_wanted();
  }
  if (*path == "/metrics") return metrics_page();
  Response response = respond(*path == "/" ? list() : catalog_.find(*path), request);
  if (!access()->viewing_is_public()) make_private(response);
  if (!page_.empty() && has_page(*path)) response.fields += "Vary: Accept\r\n";
  return response;
}

bool Service::has_page(std::string_view path) const {
  if (path == "/") return true;
  if (path.starts_with(kLivePath)) {
    return relay_ != nullptr && is_stream_name(path.substr(kLivePath.size()));
  }
  // With a token, whoever has none must not learn which reels there are.
  if (!access()->viewing_is_public()) {
    return path != "/metrics" && !path.ends_with(kManifestEnd);
  }
  const std::shared_ptr<const Resource> resource = catalog_.find(path);
  return resource != nullptr && resource->kind == Resource::Kind::kRedirect;
}

std::shared_ptr<const Resource> Service::page_at(const std::string& path,
                                                 const Request& request) const {
  if (page_.empty()) return nullptr;
  if (auto file = page_.find(path, request.accept_encoding)) return file;
  if (!names_acceptable(request.accept, "text/html") || !has_page(path)) return nullptr;
  // The page names its files relative to the address without the last slash.
  if (path.size() > 1 && path.ends_with('/')) {
    return std::make_shared<const Resource>(
        redirect_resource(encode_path(path.substr(1, path.size() - 2))));
  }
  return page_.start(request.accept_encoding);
}

std::variant<Response, LiveCall> Service::live_call(const Request& request, const Peer& peer,
                                                    std::string stream,
                                                    std::function<void()> wake) {
  const bool publishes = query_has(request.target, "publish");
  if (!origins_.allows(request.origin, request.host)) {
    return error_response(403,
                          "pages of this origin may not connect; start the server with "
                          "--allow-origin to let them");
  }
  // A request through a proxy comes from elsewhere, and a page in a browser on this machine does
  // not act on behalf of its user. A proxy need not say that it is one, so a connection counts as
  // local only if it must be, or if somebody has said so.
  const bool nearby =
      local_publish_ && peer.loopback && !request.forwarded && request.origin.empty();
  switch (access()->check(publishes ? Access::Right::kPublish : Access::Right::kView,
                          live_credentials(request), nearby)) {
    case Access::Verdict::kGranted:
      break;
    case Access::Verdict::kNoToken:
      return token_wanted();
    case Access::Verdict::kOnlyNearby:
      return error_response(
          403,
          "only programs on the server's own machine may publish, since no publish token is set, "
          "and only if the server listens on loopback alone");
  }
  LiveCall call;
  call.protocol = names_acceptable(request.protocols, kLiveProtocol);
  if (publishes) {
    auto publication = relay_->publish(stream);
    if (!publication) return error_response(400, publication.error().message);
    call.hello = PeerQuota::Share(hellos_, peer);
    if (!call.hello.grow(1)) {
      metrics_.count_refused(Metrics::Refused::kHellos);
      return error_response(503, "too many publishers have not said hello yet; try again",
                            "Retry-After: 1\r\n");
    }
    call.publication = *std::move(publication);
  } else if (stream.empty()) {
    call.viewer = relay_->watch(std::move(wake));
  } else {
    auto viewer = relay_->join(stream, std::move(wake), query_has(request.target, "sound"));
    if (!viewer) return error_response(404, viewer.error().message);
    call.viewer = *std::move(viewer);
  }
  call.stream = std::move(stream);
  return call;
}

Response Service::refuse(Response refusal) {
  metrics_.count_response(refusal.status);
  return refusal;
}

std::shared_ptr<const Resource> Service::list() const {
  return catalog_.list([this] {
    return relay_ != nullptr ? relay_->statistics() : std::vector<StreamStatistics>();
  });
}

Response Service::metrics_page() const {
  Gauges gauges;
  if (table_ != nullptr) {
    gauges.open_connections = table_->count();
    gauges.evicted_connections = table_->evicted();
  }
  if (relay_ != nullptr) gauges.streams = relay_->statistics();
  gauges.waiting_hellos = hellos_.held();
  gauges.unfinished_bytes = unfinished_.held();
  Response response;
  response.own_text = write_metrics(metrics_, gauges);
  response.size = response.own_text.size();
  response.fields = fmt::format(
      "Content-Type: text/plain; version=0.0.4; charset=utf-8\r\nContent-Length: {}\r\n"
      "Cache-Control: no-store\r\n",
      response.size);
  return response;
}

}  // namespace pointreel
