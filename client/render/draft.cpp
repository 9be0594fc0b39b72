#include "client/render/draft.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace pointreel {
namespace {

/// Shorter delays are not noticed by hand.
constexpr double kHandMs = 16.0;
/// The share of the frame interval that drawing may take. Frames are decoded at the same time.
constexpr double kShareOfClock = 0.75;
struct Level {
  DraftCoarsening coarsening;
  double share;  ///< of the time that a picture takes at level 0
};
/// Measured with 882,000 surfels.
constexpr std::array<Level, 4> kLevels = {{
    {{1, 1.0f}, 1.0},
    {{1, 1.25f}, 0.6},
    {{2, 1.0f}, 0.3},
    {{4, 1.0f}, 0.12},
}};
constexpr double kLeastShare = 0.3;  ///< of level 1
constexpr int kCoarsest = static_cast<int>(kLevels.size()) - 1;
/// This level gains nothing in scenes whose elements are all larger than a pixel.
constexpr int kLarger = 1;
constexpr int kHalf = 2;  ///< the level before anything was measured
/// The share of the first picture's time that is taken for drawing. The rest is the compilation of
/// shaders.
constexpr double kTrustInFirst = 0.25;

/// The level becomes coarser after this many pictures that take too long, or after fewer that take
/// much too long.
constexpr int kLate = 3;
/// The share of the time that a finer level may be predicted to take.
constexpr double kRoom = 0.7;
constexpr int kPatience = 30, kMostPatience = 16 * kPatience;

}  // namespace

double Draft::share(int level) const {
  if (level == kLarger && larger_share_ > 0.0) return larger_share_;
  return kLevels[static_cast<std::size_t>(level)].share;
}

double Draft::predicted(int level) const {
  return share(level) * ms_per_element_ * static_cast<double>(elements_);
}

int Draft::finest_within(double ms) const {
  int level = 0;
  while (level < kCoarsest && predicted(level) > ms) ++level;
  return level;
}

DraftCoarsening Draft::coarsening(const Haste& haste, std::uint64_t elements) {
  elements_ = std::max<std::uint64_t>(elements, 1);
  const int before = level_;
  if (haste.of == Haste::Of::nobody) {
    level_ = 0;
    larger_share_ = 0.0;
  } else if (drawn_ == 0) {
    level_ = kHalf;
  } else if (haste.of == Haste::Of::hand) {
    level_ = std::max(before, finest_within(kHandMs));
  } else {
    level_ = level_at_clock(kShareOfClock * haste.frame_ms);
  }
  at_clock_ = haste.of == Haste::Of::clock && drawn_ > 0;
  return kLevels[static_cast<std::size_t>(level_)].coarsening;
}

int Draft::level_at_clock(double ms) {
  if (!at_clock_) {
    late_ = in_time_ = 0;
    since_finer_ = kMostPatience;
    patience_ = kPatience;
    // What plays first is never coarser than half: it may turn out that there is time for more.
    return std::min(finest_within(drawn_ > 1 ? ms : ms / kTrustInFirst), kHalf);
  }
  ++since_finer_;
  // A single late picture now and then may be due to anything else on the machine.
  const double share = predicted(level_) / std::max(ms, 1e-3);
  late_ = share > 1.0 ? late_ + static_cast<int>(std::min<double>(share, kLate))
                      : std::max(0, late_ - 1);
  in_time_ = level_ > 0 && predicted(level_ - 1) < kRoom * ms ? in_time_ + 1 : 0;
  if (late_ >= kLate && level_ < kCoarsest) {
    // The last attempt at a finer level failed: wait twice as long before the next.
    if (since_finer_ < patience_) patience_ = std::min(2 * patience_, kMostPatience);
    late_ = in_time_ = 0;
    since_finer_ = kMostPatience;
    const bool useless = level_ + 1 == kLarger && predicted(kLarger) > ms;
    return useless ? kHalf : level_ + 1;
  }
  if (in_time_ >= patience_) {
    late_ = in_time_ = since_finer_ = 0;
    return level_ - 1;
  }
  return level_;
}

void Draft::drew(std::uint64_t elements, double ms) {
  const double per_element = ms / static_cast<double>(std::max<std::uint64_t>(elements, 1));
  if (level_ + drawn_level_ == kLarger && drawn_ > 1) {
    const double ratio = per_element / drawn_per_element_;
    larger_share_ = std::clamp(level_ == kLarger ? ratio : 1.0 / ratio, kLeastShare, 1.0);
  }
  drawn_level_ = level_;
  drawn_per_element_ = per_element;
  drawn_ = std::min(drawn_ + 1, 2);
  // After a coarser level, nobody knows yet what this one gains. Trying the next finer one tells.
  const bool unknown = level_ == kLarger && larger_share_ <= 0.0;
  ms_per_element_ = unknown ? per_element : per_element / share(level_);
}

std::uint64_t element_count(const Scene& scene) {
  std::uint64_t count = 0;
  for (const PlacedFrame& placed : scene) {
    if (!placed.frame) continue;
    const std::uint64_t leaves = placed.frame->svo.leaf_count();
    count += leaves > 0 ? leaves : placed.frame->cloud.size();
  }
  return count;
}

}  // namespace pointreel
