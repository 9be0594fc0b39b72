#include "codec/rate/quality_search.h"

#include <algorithm>
#include <cmath>

namespace pointreel {
namespace {

/// Of the dense person in BENCHMARKS.md, at quality 30: bits of a point, and by how much their
/// logarithm grows with the quality.
constexpr double kBitsAt30 = 0.076, kLogGrowth = 0.022;
/// The share of the budget that is aimed at, and the least that is good enough.
constexpr double kAim = 0.95, kEnough = 0.85;
/// From then on, what fits is taken.
constexpr int kTries = 4;

}  // namespace

QualitySearch::QualitySearch(double budget, int asked, std::uint64_t points)
    : budget_(budget), above_(asked + 1) {
  const double bits = 8.0 * budget / static_cast<double>(std::max<std::uint64_t>(points, 1));
  const double guess = 30.0 + std::log(std::max(kAim * bits / kBitsAt30, 1e-9)) / kLogGrowth;
  quality_ = static_cast<int>(std::clamp(guess, 1.0, static_cast<double>(asked)));
}

bool QualitySearch::accepts(double bytes) {
  ++tries_;
  fits_ = bytes <= budget_;
  if (fits_) {
    below_ = quality_;
    below_bytes_ = bytes;
  } else {
    above_ = quality_;
    above_bytes_ = bytes;
  }
  const bool none_between = above_ - below_ <= 1;
  const bool last =
      fits_ ? none_between || bytes >= kEnough * budget_ || tries_ >= kTries : quality_ == 1;
  if (!last) choose();
  return last;
}

void QualitySearch::choose() {
  if (above_ - below_ <= 1 || (tries_ >= kTries && below_ > 0)) {
    quality_ = below_;
    return;
  }
  const auto log = [](double bytes) { return std::log(std::max(bytes, 1.0)); };
  const double wanted = log(kAim * budget_);
  double quality = 0.0;
  if (below_ > 0 && above_bytes_ > 0.0) {
    const double low = log(below_bytes_), high = log(above_bytes_);
    quality = below_ + (above_ - below_) * (wanted - low) / std::max(high - low, 1e-9);
  } else {
    const double from = fits_ ? below_bytes_ : above_bytes_;
    quality = quality_ + (wanted - log(from)) / kLogGrowth;
  }
  quality_ = static_cast<int>(std::clamp<double>(quality, below_ + 1, above_ - 1));
}

}  // namespace pointreel
