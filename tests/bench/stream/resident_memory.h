#pragma once

#include <cstddef>
#include <vector>

#include <sys/types.h>

namespace pointreel::bench {

/// The resident memory of a process in KiB; 0 if there is no such process.
double resident_kib(pid_t pid);

/// Samples of resident memory over the progress of something, such as frames or connections.
class MemoryGrowth {
 public:
  void add(double progress, double kib) { samples_.push_back({progress, kib}); }
  /// The growth in KiB for each `unit` of progress, by least squares over the last 30 % of the
  /// progress. Everything before counts as warm-up: a player keeps 65,536 times of each stage.
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
