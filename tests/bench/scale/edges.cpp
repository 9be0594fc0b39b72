#include "tests/bench/scale/edges.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/bench/scale/lru_cache.h"

namespace pointreel::bench {
namespace {

/// What a viewer asks for in one second of a trace, of one layer of one segment.
struct Step {
  std::uint32_t segment, layer;
  double requests, bytes;
};

struct Pattern {
  std::vector<std::vector<Step>> seconds;
  std::uint32_t advance = 0;  ///< segments from the beginning of one repetition to the next
};

Pattern pattern_of(const Trace& trace, double trace_rate, const PlannedReel& reel) {
  Pattern pattern;
  double last = 0.0;
  for (const LoggedRequest& request : trace) last = std::max(last, request.seconds);
  pattern.seconds.resize(static_cast<std::size_t>(last) + 1);
  const double more_frames = reel.frame_rate / trace_rate;
  for (const LoggedRequest& request : trace) {
    pattern.advance = std::max(pattern.advance, request.segment + 1);
    if (request.layer >= reel.frame_bytes.size()) continue;
    const double bytes = more_frames * reel.frame_bytes[request.layer];
    std::vector<Step>& steps = pattern.seconds[static_cast<std::size_t>(request.seconds)];
    const auto same = std::find_if(steps.begin(), steps.end(), [&](const Step& step) {
      return step.segment == request.segment && step.layer == request.layer;
    });
    if (same == steps.end()) {
      steps.push_back({request.segment, request.layer, more_frames, bytes});
    } else {
      same->requests += more_frames;
      same->bytes += bytes;
    }
  }
  return pattern;
}

struct Viewer {
  double start;           ///< seconds since the first may come
  std::uint32_t segment;  ///< where the viewer begins
};

std::vector<Viewer> viewers_of(const Audience& audience, std::uint32_t segments) {
  std::mt19937_64 random(1);
  const auto share = [&] { return std::ldexp(static_cast<double>(random() >> 11), -53); };
  std::vector<Viewer> viewers(audience.viewers);
  for (std::size_t i = 0; i < viewers.size(); ++i) {
    const double place = share() < audience.from_start ? 0.0 : share();
    viewers[i] = {
        audience.arrival_seconds * static_cast<double>(i) / static_cast<double>(viewers.size()),
        static_cast<std::uint32_t>(place * segments)};
  }
  return viewers;
}

}  // namespace

EdgeFigures simulate(const PlannedReel& reel, const Audience& audience, const EdgeCaches& edges,
                     std::span<const Trace> traces, double trace_rate) {
  const auto segments =
      std::max(1u, static_cast<std::uint32_t>(3600.0 * reel.hours / reel.segment_seconds));
  const auto layers = static_cast<std::uint32_t>(reel.frame_bytes.size());
  std::vector<std::uint64_t> file_bytes(layers);
  for (std::uint32_t layer = 0; layer < layers; ++layer)
    file_bytes[layer] = std::max<std::uint64_t>(
        1, static_cast<std::uint64_t>(reel.frame_bytes[layer] * reel.frame_rate *
                                      reel.segment_seconds));
  std::vector<Pattern> patterns;
  for (const Trace& trace : traces) patterns.push_back(pattern_of(trace, trace_rate, reel));
  std::vector<LruCache> caches(edges.count, LruCache(segments * layers, edges.bytes_each));

  EdgeFigures figures;
  const std::vector<Viewer> viewers = viewers_of(audience, segments);
  std::size_t first = 0, end = 0;  // viewers who are watching
  for (double now = 0.0; first < viewers.size(); now += 1.0) {
    while (end < viewers.size() && viewers[end].start <= now) ++end;
    while (first < end && viewers[first].start + audience.session_seconds <= now) ++first;
    double requests = 0.0, bytes = 0.0, store_bytes = 0.0;
    for (std::size_t i = first; i < end; ++i) {
      const Pattern& pattern = patterns[i % patterns.size()];
      const auto second = static_cast<std::size_t>(now - viewers[i].start);
      const auto repetition = static_cast<std::uint32_t>(second / pattern.seconds.size());
      const std::uint32_t from = viewers[i].segment + repetition * pattern.advance;
      // Neighbouring viewers go to different edges, and those of one trace to all.
      LruCache& cache = caches[i / patterns.size() % caches.size()];
      for (const Step& step : pattern.seconds[second % pattern.seconds.size()]) {
        const std::uint32_t segment = (from + step.segment) % segments;
        requests += step.requests;
        bytes += step.bytes;
        if (cache.use(segment * layers + step.layer, file_bytes[step.layer])) continue;
        figures.store_requests += 1.0;
        store_bytes += static_cast<double>(file_bytes[step.layer]);
      }
    }
    figures.requests += requests;
    figures.bytes += bytes;
    figures.store_bytes += store_bytes;
    figures.most_requests = std::max(figures.most_requests, requests);
    figures.most_bytes = std::max(figures.most_bytes, bytes);
    figures.most_store_bytes = std::max(figures.most_store_bytes, store_bytes);
  }
  return figures;
}

}  // namespace pointreel::bench
