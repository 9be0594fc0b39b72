#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tests/bench/scale/request_log.h"

namespace pointreel::bench {

/// A reel that many watch.
struct PlannedReel {
  double hours = 10.0;
  double segment_seconds = 1.0;
  double frame_rate = 60.0;
  /// Bytes of a frame in each layer, from coarse to fine.
  std::vector<double> frame_bytes;
};

struct Audience {
  std::uint32_t viewers = 100'000;
  double arrival_seconds = 3600.0;  ///< they come evenly spread over this time
  double session_seconds = 600.0;   ///< for how long each watches
  double from_start = 0.7;          ///< the share that begins at the start; others begin anywhere
};

/// Caches between the viewers and the store. Each viewer always asks the same one.
struct EdgeCaches {
  std::uint32_t count = 50;
  std::uint64_t bytes_each = 100'000'000'000;
};

/// What one viewer asked for, one frame of a layer at a time.
using Trace = std::vector<LoggedRequest>;

struct EdgeFigures {
  double requests = 0.0, bytes = 0.0;              ///< to viewers
  double store_requests = 0.0, store_bytes = 0.0;  ///< from the store to edges
  double most_requests = 0.0, most_bytes = 0.0;    ///< in the busiest second
  double most_store_bytes = 0.0;                   ///< in the busiest second
};

/// Lets each viewer repeat one of the traces from where the viewer begins. The traces are of a reel
/// with `trace_rate` frames a second; requests are scaled to the rate of the planned reel, and
/// their bytes are those of its layers. An edge fetches a whole layer of a segment when a part of
/// it is asked for; several viewers who ask at the same time cause one fetch. The same arguments
/// give the same figures.
EdgeFigures simulate(const PlannedReel& reel, const Audience& audience, const EdgeCaches& edges,
                     std::span<const Trace> traces, double trace_rate);

}  // namespace pointreel::bench
