#pragma once

#include <memory>

#include "server/serve/asio_types.h"
#include "server/serve/transport.h"
#include "server/service/connection_table.h"
#include "server/service/limits.h"
#include "server/service/peer.h"
#include "server/service/service.h"

/// HTTP/1.1 over a transport. The coroutines must be spawned on the transport's strand.
namespace pointreel {

/// Answers requests until the peer closes the connection, makes an error or stalls. If a request
/// upgrades the connection to a WebSocket, serves that until it ends. `place` must live as long as
/// the transport.
Task<void> serve_connection(std::shared_ptr<Transport> transport, ConnectionTable::Place& place,
                            Peer peer, Service& service, const Limits& limits);

/// Tells a connection that there is no room for it.
Task<void> refuse_connection(std::shared_ptr<Transport> transport,
                             ConnectionTable::Refusal refusal);

}  // namespace pointreel
