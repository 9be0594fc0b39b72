#pragma once

#include <chrono>
#include <memory>

#include "server/serve/asio_types.h"
#include "server/serve/catalog.h"
#include "server/serve/transport.h"

/// HTTP/1.1 over a transport, to be spawned on the transport's strand.
namespace pointreel {

struct ConnectionTimes {
  std::chrono::milliseconds header, idle;
};

/// Answers requests until the peer ends, errs or stalls.
Task<void> serve_connection(std::shared_ptr<Transport> transport, const Catalog& catalog,
                            ConnectionTimes times);

/// Tells a connection that there is no room for it.
Task<void> refuse_connection(std::shared_ptr<Transport> transport);

}  // namespace pointreel
