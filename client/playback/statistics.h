#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pointreel {

struct TimeSummary {
  double median = 0.0, p95 = 0.0, max = 0.0;  ///< all 0 if nothing was measured
};

/// Measured times of one stage of playing. Keeps the newest kMaxSamples, so that a player can run
/// for days without growing; `max` is the maximum of all.
class TimeSamples {
 public:
  static constexpr std::size_t kMaxSamples = 1u << 16;

  void add(double ms);
  /// Median and 95th percentile by nearest rank: the smallest sample that is at least as large as
  /// that share of all.
  TimeSummary summary() const;

 private:
  std::vector<double> newest_;
  std::size_t next_ = 0;  ///< the sample to overwrite next, once `newest_` is full
  double max_ = 0.0;
};

}  // namespace pointreel
