#pragma once

#include <cstdint>
#include <optional>

namespace pointreel {

struct FrameRange {
  std::uint32_t first = 0, last = 0;  ///< both included; first <= last

  bool operator==(const FrameRange&) const = default;
};

/// Which frame follows which when a reel is played: from one end to the other, and on from there if
/// it loops. If there is a range, playback that starts before the range's far end stays in the
/// range once it is there. A plain value.
struct PlayOrder {
  std::uint32_t count = 1;  ///< frames of the reel, >= 1; all frame numbers are below it
  bool loop = true;         ///< playback goes on at the other end of the reel
  int direction = 1;        ///< or -1
  std::optional<FrameRange> range;

  /// The frame `steps` after `from`; none beyond an end, or once frames would only repeat.
  std::optional<std::uint32_t> after(std::uint32_t from, std::uint32_t steps) const;
  /// How many steps after `from` playback first reaches `to`; none if it never does.
  std::optional<std::uint32_t> steps(std::uint32_t from, std::uint32_t to) const;

 private:
  /// Converts frame numbers to numbers counted from the end where playing begins, and back.
  std::uint32_t turned(std::uint32_t frame) const {
    return direction < 0 ? count - 1 - frame : frame;
  }
  /// The range in those numbers; all frames if there is none and the reel loops.
  std::optional<FrameRange> turned_range() const;
};

}  // namespace pointreel
