#pragma once

#include <cstdint>
#include <optional>

namespace pointreel {

struct FrameRange {
  std::uint32_t first = 0, last = 0;  ///< both of it; first <= last

  bool operator==(const FrameRange&) const = default;
};

/// Which frame follows which as a reel is played: from one end to the other, and on from there when
/// looping; in a range that is looped in, again and again from where it is come to, which is from
/// before its far end. A plain value.
struct PlayOrder {
  std::uint32_t count = 1;  ///< frames of the reel; >= 1, all others below it
  bool loop = true;         ///< goes on at the other end of the reel
  int direction = 1;        ///< or -1
  std::optional<FrameRange> range;

  /// The frame `steps` after `from`; none beyond an end, or if each that follows has been before.
  std::optional<std::uint32_t> after(std::uint32_t from, std::uint32_t steps) const;
  /// So many steps after `from` comes `to` for the first time; nothing if it never does.
  std::optional<std::uint32_t> steps(std::uint32_t from, std::uint32_t to) const;

 private:
  /// Frames counted from the end where playing begins, and back.
  std::uint32_t turned(std::uint32_t frame) const {
    return direction < 0 ? count - 1 - frame : frame;
  }
  /// The range in those; all frames where there is none and the reel loops.
  std::optional<FrameRange> turned_range() const;
};

}  // namespace pointreel
