#pragma once

#include <memory>

#include "server/serve/asio_types.h"
#include "server/serve/limits.h"
#include "server/serve/peer.h"
#include "server/serve/service.h"
#include "server/serve/transport.h"

/// HTTP/1.1 over a transport, to be spawned on the transport's strand.
namespace pointreel {

/// Answers requests until the peer ends, errs or stalls, or goes on as a WebSocket and ends that.
Task<void> serve_connection(std::shared_ptr<Transport> transport, Peer peer, Service& service,
                            const Limits& limits);

/// Tells a connection that there is no room for it.
Task<void> refuse_connection(std::shared_ptr<Transport> transport);

}  // namespace pointreel
