#include "codec/rate/rate_control.h"

#include <algorithm>
#include <cmath>

#include "pointreel/octree.h"

namespace pointreel {
namespace {

/// If this share of the budget is used, another trial is not worthwhile.
constexpr double kUsedWell = 0.95;

/// The number of levels between two sizes, if each level quarters the size; at least one. Counted
/// rather than computed as a logarithm, so that the result does not depend on rounding.
int levels_between(double more, double less) {
  int levels = 1;
  for (double size = more / 16.0; size >= less && levels < kMaxDepth; size /= 4.0) ++levels;
  return levels;
}

}  // namespace

void RateControl::told(double bytes, int depth) {
  ++trials_;
  const Coarsening tried = *next_;
  const bool fits = bytes <= budget_;
  switch (phase_) {
    case Phase::asked:
      finest_ = depth;
      if (fits) return settle(tried, bytes, true);
      phase_ = Phase::levels;
      // If the size is not far from the budget, coarser attributes alone may suffice.
      if (!attributes_ || bytes > 4.0 * budget_) levels_too_few_ = 0;
      return seek_levels(bytes);
    case Phase::levels:
      if (fits) {
        levels_enough_ = tried.levels;
        enough_bytes_ = bytes;
      } else {
        levels_too_few_ = tried.levels;
      }
      return seek_levels(bytes);
    case Phase::quality:
      if (fits) {
        quality_enough_ = tried.quality;
        enough_bytes_ = bytes;
      } else {
        quality_too_little_ = tried.quality;
      }
      if (quality_too_little_ < quality_enough_) return seek_quality();
      // After an overshoot, even the coarsest attributes at this depth are too much.
      levels_too_few_ = tried.levels;
      levels_enough_.reset();
      phase_ = Phase::levels;
      return seek_levels(bytes);
  }
}

bool RateControl::overshot(double bytes) {
  if (!within_budget_) return false;
  budget_ *= std::min(1.0, choice_bytes_ / bytes);
  if (choice_ != coarse_at(choice_.levels)) {
    // The attributes were not yet as coarse as this depth allows.
    levels_enough_ = choice_.levels;
    quality_too_little_ = choice_.quality;
    quality_enough_ = coarse_at(choice_.levels).quality;
    phase_ = Phase::quality;
    next_ = coarse_at(choice_.levels);
    return true;
  }
  levels_too_few_ = choice_.levels;
  levels_enough_.reset();
  if (levels_too_few_ >= max_levels()) {
    within_budget_ = false;
    return false;
  }
  phase_ = Phase::levels;
  next_ = coarse_at(levels_too_few_ + 1);
  return true;
}

int RateControl::max_levels() const { return std::max(0, finest_ - kCoarsestDepth); }

Coarsening RateControl::coarse_at(int levels) const {
  return {levels, attributes_ ? most_quality_lost(levels) : 0};
}

void RateControl::seek_levels(double bytes) {
  const int most = max_levels();
  if (!levels_enough_ && levels_too_few_ >= most) {
    return settle(coarse_at(most), bytes, false);
  }
  if (levels_enough_ == levels_too_few_ + 1) {
    phase_ = Phase::quality;
    quality_enough_ = coarse_at(*levels_enough_).quality;
    // If no level is taken away, the full quality is known to be too much.
    quality_too_little_ = *levels_enough_ == 0 ? 0 : -1;
    return seek_quality();
  }
  const int levels =
      levels_enough_
          ? std::max(levels_too_few_ + 1, *levels_enough_ - levels_between(budget_, bytes))
          : std::min(most, levels_too_few_ + levels_between(bytes, budget_));
  next_ = coarse_at(levels);
}

void RateControl::seek_quality() {
  const int levels = *levels_enough_;
  if (quality_enough_ - quality_too_little_ <= 1 || enough_bytes_ >= kUsedWell * budget_) {
    return settle({levels, quality_enough_}, enough_bytes_, true);
  }
  next_ = Coarsening{levels, (quality_enough_ + quality_too_little_) / 2};
}

void RateControl::settle(const Coarsening& choice, double bytes, bool within_budget) {
  choice_ = choice;
  choice_bytes_ = bytes;
  within_budget_ = within_budget;
  next_.reset();
}

}  // namespace pointreel
