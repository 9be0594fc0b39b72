#include "client/playback/play_order.h"

namespace pointreel {

std::optional<FrameRange> PlayOrder::turned_range() const {
  if (!range) return loop ? std::optional(FrameRange{0, count - 1}) : std::nullopt;
  if (direction < 0) return FrameRange{turned(range->last), turned(range->first)};
  return range;
}

std::optional<std::uint32_t> PlayOrder::after(std::uint32_t from, std::uint32_t steps) const {
  std::uint32_t at = turned(from);
  const auto cycle = turned_range();
  if (!cycle || at > cycle->last) {
    // On to the end, and from there to the other end.
    if (steps < count - at) return turned(at + steps);
    if (!loop) return std::nullopt;
    steps -= count - at;
    at = 0;
    if (steps <= cycle->last) return turned(steps);
    return std::nullopt;  // frames would only repeat
  }
  if (steps <= cycle->last - at) return turned(at + steps);
  steps -= cycle->last - at + 1;
  // If playing begins inside the range, the frames before `from` come next.
  if (at > cycle->first && steps < at - cycle->first) return turned(cycle->first + steps);
  return std::nullopt;
}

std::optional<std::uint32_t> PlayOrder::steps(std::uint32_t from, std::uint32_t to) const {
  const std::uint32_t at = turned(from), goal = turned(to);
  const auto cycle = turned_range();
  const bool past = !cycle || at > cycle->last;
  if (goal >= at && (past || goal <= cycle->last)) return goal - at;
  if (past) {
    if (loop && cycle && goal <= cycle->last) return count - at + goal;
    return std::nullopt;
  }
  if (goal >= cycle->first && goal < at) return cycle->last - at + 1 + goal - cycle->first;
  return std::nullopt;
}

}  // namespace pointreel
