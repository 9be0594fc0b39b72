#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/serve/asio_types.h"
#include "server/serve/limits.h"
#include "server/serve/service.h"
#include "server/serve/transport.h"

/// Live streams over WebSocket (RFC 6455), between a transport and the relay.
namespace pointreel {

/// Wakes who sleeps on a strand, from any thread.
class Wake : public std::enable_shared_from_this<Wake> {
 public:
  explicit Wake(const Strand& strand) : timer_(strand) {}
  /// On the strand: until it is woken. No call is lost if nothing was awaited since it was looked
  /// for whether there is something to do.
  Task<void> sleep();
  /// A call wakes; it may outlive this.
  std::function<void()> function();

 private:
  Timer timer_;
};

/// Answers the upgrade whose head, and what came behind it, is `received`, and serves the session
/// until one side ends it. Idle peers are asked (ping) whether they are still there.
///
/// Trust: messages are untrusted. Of a viewer they are bounded to 64 KiB and dropped; a publisher's
/// are bounded to what live.h allows and checked by the relay, and come no faster than the limits
/// say: it is not read from, so that TCP holds it back.
Task<void> serve_websocket(std::shared_ptr<Transport> transport, std::string received,
                           LiveCall call, std::shared_ptr<Wake> wake, Peer peer, Service& service,
                           const Limits& limits);

}  // namespace pointreel
