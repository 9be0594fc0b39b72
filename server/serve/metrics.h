#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "server/relay/relay.h"

namespace pointreel {

/// What the server counts. Any thread may add to it.
struct Metrics {
  using Count = std::atomic<std::uint64_t>;
  static constexpr int kFirstStatus = 100, kLastStatus = 599;

  void count_response(int status) {
    if (status >= kFirstStatus && status <= kLastStatus) {
      responses[static_cast<std::size_t>(status - kFirstStatus)].fetch_add(
          1, std::memory_order_relaxed);
    }
  }

  std::array<Count, kLastStatus - kFirstStatus + 1> responses{};  ///< by status
  Count body_bytes{0};              ///< of responses, as far as they were sent
  Count connections{0};             ///< that were accepted and given a place
  Count refused_full{0};            ///< connections for which there was no place at all
  Count refused_address{0};         ///< connections of an address that had enough
  Count failed_handshakes{0};       ///< of TLS
  Count limited_requests{0};        ///< that came too fast
  Count viewers{0}, publishers{0};  ///< live sessions that began
};

/// What is so now.
struct Gauges {
  std::size_t open_connections = 0, evicted_connections = 0;
  std::vector<StreamStatistics> streams;
};

/// In Prometheus's text format, version 0.0.4; with the process's memory, descriptors and start.
std::string write_metrics(const Metrics& metrics, const Gauges& gauges);

}  // namespace pointreel
