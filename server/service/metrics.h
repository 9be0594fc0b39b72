#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "server/relay/relay.h"

namespace pointreel {

/// The server's counters. Any thread may increase them.
struct Metrics {
  using Count = std::atomic<std::uint64_t>;
  static constexpr int kFirstStatus = 100, kLastStatus = 599;

  /// Why a publisher was refused.
  enum class Refused : std::size_t {
    kHellos,    ///< too many had not said hello
    kNoHello,   ///< it did not say hello in time
    kSlow,      ///< its message came too slowly
    kBytes,     ///< too many bytes of messages were not complete
    kMessages,  ///< what it sent is not allowed
    kCount
  };
  void count_refused(Refused why) { ++refused_publishers[static_cast<std::size_t>(why)]; }

  void count_response(int status) {
    if (status >= kFirstStatus && status <= kLastStatus) {
      responses[static_cast<std::size_t>(status - kFirstStatus)].fetch_add(
          1, std::memory_order_relaxed);
    }
  }

  std::array<Count, kLastStatus - kFirstStatus + 1> responses{};  ///< by status
  Count body_bytes{0};              ///< sent in the bodies of responses
  Count connections{0};             ///< accepted connections that got a place
  Count refused_full{0};            ///< connections that were refused because the table was full
  Count refused_address{0};         ///< connections from addresses that had too many
  Count failed_handshakes{0};       ///< of TLS
  Count limited_requests{0};        ///< requests that came too fast
  Count viewers{0}, publishers{0};  ///< live sessions that have begun
  std::array<Count, static_cast<std::size_t>(Refused::kCount)> refused_publishers{};
};

/// The present state.
struct Gauges {
  std::size_t open_connections = 0, evicted_connections = 0;
  std::vector<StreamStatistics> streams;
  std::size_t waiting_hellos = 0;    ///< publishers that have not said hello
  std::size_t unfinished_bytes = 0;  ///< of publishers' messages that are not complete
};

/// Writes both in Prometheus's text format, version 0.0.4, together with the memory, descriptors,
/// processor time and start of the process.
std::string write_metrics(const Metrics& metrics, const Gauges& gauges);

}  // namespace pointreel
