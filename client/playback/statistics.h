#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pointreel {

struct TimeSummary {
  double median = 0.0, p95 = 0.0, max = 0.0;  ///< all 0 where nothing was measured
};

/// Measured times of one stage. Keeps the newest kMaxSamples, so that a player which runs for days
/// does not grow; `max` is over all.
class TimeSamples {
 public:
  static constexpr std::size_t kMaxSamples = 1u << 16;

  void add(double ms);
  /// Median and 95th percentile by nearest rank: the smallest sample that is not below that share
  /// of all.
  TimeSummary summary() const;

 private:
  std::vector<double> newest_;
  std::size_t next_ = 0;  ///< is overwritten next once `newest_` is full
  double max_ = 0.0;
};

}  // namespace pointreel
