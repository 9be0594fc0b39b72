#pragma once

#include <cstddef>
#include <vector>

#include <sys/types.h>

namespace pointreel::bench {

/// Resident memory of a process in KiB; 0 if there is none.
double resident_kib(pid_t pid);

/// Resident memory as something goes on, such as frames or connections.
class MemoryGrowth {
 public:
  void add(double progress, double kib) { samples_.push_back({progress, kib}); }
  /// KiB for each `unit` of progress by least squares, over the last 30 % of the progress: what was
  /// taken before is warm-up. (A player keeps 65,536 times of each stage.)
  double slope(double unit) const;
  double first_kib() const { return samples_.empty() ? 0.0 : samples_.front().kib; }
  double last_kib() const { return samples_.empty() ? 0.0 : samples_.back().kib; }
  std::size_t size() const { return samples_.size(); }

 private:
  struct Sample {
    double progress, kib;
  };
  std::vector<Sample> samples_;
};

}  // namespace pointreel::bench
