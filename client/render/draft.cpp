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
/// How long a picture takes at each level, as a share of level 0. Measured with 916,000 surfels on
/// software OpenGL.
constexpr std::array<double, Draft::kCoarsest + 1> kShare = {1.0, 0.3, 0.12};
constexpr int kUnknown = 1;  ///< the level before anything was measured
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

double Draft::predicted(int level) const {
  return kShare[static_cast<std::size_t>(level)] * ms_per_element_ * static_cast<double>(elements_);
}

int Draft::finest_within(double ms) const {
  int level = 0;
  while (level < kCoarsest && predicted(level) > ms) ++level;
  return level;
}

int Draft::reduction(const Haste& haste, std::uint64_t elements) {
  elements_ = std::max<std::uint64_t>(elements, 1);
  const int before = level_;
  if (haste.of == Haste::Of::nobody)
    level_ = 0;
  else if (drawn_ == 0)
    level_ = kUnknown;
  else if (haste.of == Haste::Of::hand)
    level_ = std::max(before, finest_within(kHandMs));
  else
    level_ = level_at_clock(kShareOfClock * haste.frame_ms);
  at_clock_ = haste.of == Haste::Of::clock && drawn_ > 0;
  return 1 << level_;
}

int Draft::level_at_clock(double ms) {
  if (!at_clock_) {
    late_ = in_time_ = since_finer_ = 0;
    patience_ = kPatience;
    // What plays first is never coarser than half: it may turn out that there is time for more.
    return std::min(finest_within(drawn_ > 1 ? ms : ms / kTrustInFirst), kUnknown);
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
    return level_ + 1;
  }
  if (in_time_ >= patience_) {
    late_ = in_time_ = since_finer_ = 0;
    return level_ - 1;
  }
  return level_;
}

void Draft::drew(std::uint64_t elements, double ms) {
  drawn_ = std::min(drawn_ + 1, 2);
  ms_per_element_ = ms / kShare[static_cast<std::size_t>(level_)] /
                    static_cast<double>(std::max<std::uint64_t>(elements, 1));
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
