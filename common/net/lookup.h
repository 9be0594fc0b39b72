#pragma once

#include <chrono>
#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include <boost/asio/ip/tcp.hpp>

#include "pointreel/error.h"

namespace pointreel {

/// The addresses of a host, which is a name or an address itself. Fails with `io` if there are none
/// or no answer comes within `timeout`, and with `cancelled` once `stop` is requested. The system's
/// lookup cannot be interrupted: it goes on by itself, on a thread of its own, when this has
/// failed.
Result<std::vector<boost::asio::ip::tcp::endpoint>> look_up(const std::string& host,
                                                            std::uint16_t port,
                                                            std::chrono::milliseconds timeout,
                                                            const std::stop_token& stop);

}  // namespace pointreel
