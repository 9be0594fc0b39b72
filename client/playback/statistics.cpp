#include "client/playback/statistics.h"

#include <algorithm>
#include <cmath>

namespace pointreel {

void TimeSamples::add(double ms) {
  max_ = std::max(max_, ms);
  if (newest_.size() < kMaxSamples) {
    newest_.push_back(ms);
    return;
  }
  newest_[next_] = ms;
  next_ = (next_ + 1) % kMaxSamples;
}

TimeSummary TimeSamples::summary() const {
  if (newest_.empty()) return {};
  std::vector<double> sorted = newest_;
  std::sort(sorted.begin(), sorted.end());
  const auto rank = [&](double share) {
    const double n = std::ceil(share * static_cast<double>(sorted.size()));
    return sorted[static_cast<std::size_t>(std::max(1.0, n)) - 1];
  };
  return {rank(0.5), rank(0.95), max_};
}

}  // namespace pointreel
