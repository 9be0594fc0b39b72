#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/serve/asio_types.h"
#include "server/serve/transport.h"
#include "server/service/limits.h"
#include "server/service/service.h"

/// Live streams over WebSocket (RFC 6455), between a transport and the relay.
namespace pointreel {

/// Wakes a coroutine that sleeps on a strand, from any thread.
class Wake : public std::enable_shared_from_this<Wake> {
 public:
  explicit Wake(const Strand& strand) : timer_(strand) {}
  /// Sleeps until it is woken. Must be called on the strand. No wake-up is lost, provided that
  /// nothing was awaited since it was checked whether there is something to do.
  Task<void> sleep();
  /// A function that wakes the coroutine. It may outlive this object.
  std::function<void()> function();

 private:
  Timer timer_;
};

/// Answers an upgrade request and serves the session until one side ends it. `received` is the head
/// of the request and whatever came after it. Idle peers are pinged.
///
/// Trust: messages are untrusted. Those of a viewer may have up to 64 KiB and are ignored. Those of
/// a publisher are bounded by Limits::max_message, or if they are text by kMaxLiveText, and checked
/// by the relay. A publisher that exceeds Limits::publish_rate or publish_text_rate is not read
/// from for a while, so that TCP holds it back. One that does not say hello in time, sends a
/// message more slowly than Limits::least_rate, or would exceed the bytes that unfinished messages
/// may have, is disconnected.
Task<void> serve_websocket(std::shared_ptr<Transport> transport, std::string received,
                           LiveCall call, std::shared_ptr<Wake> wake, Peer peer, Service& service,
                           const Limits& limits);

}  // namespace pointreel
