#include "client/window/motion.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;

/// A camera that was moved by hand counts as moving for so long.
constexpr milliseconds kCameraMoves{150};
/// Playback counts as standing still if no other frame was shown for so long.
constexpr milliseconds kClockRuns{1000};

}  // namespace

Haste WindowMotion::haste(Drafts drafts, const Stage& stage, bool by_hand, TimePoint now) const {
  if (drafts == Drafts::never) return {};
  if (by_hand || flying_ || now - moved_ < kCameraMoves) return {Haste::Of::hand};
  if (drafts == Drafts::playing && stage.playing() && now - shown_ < kClockRuns)
    return {Haste::Of::clock, 1000.0 * stage.frame_seconds()};
  return {};
}

std::optional<WindowMotion::TimePoint> WindowMotion::next_rest(TimePoint now) const {
  if (now - moved_ < kCameraMoves) return moved_ + kCameraMoves;
  if (now - shown_ < kClockRuns) return shown_ + kClockRuns;
  return std::nullopt;
}

}  // namespace pointreel
