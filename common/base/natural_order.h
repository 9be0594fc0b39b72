#pragma once

#include <cstddef>
#include <string_view>

namespace pointreel {

/// True if `a` comes before `b` in natural order: runs of the digits 0 to 9 compare by the number
/// they spell, of any length, and everything else compares byte by byte, without regard to the case
/// of letters, so frame2 comes before Frame10. Names that are equal in this sense (frame1, frame01)
/// are ordered byte by byte, which makes the order total. O(length); allocates nothing.
bool natural_less(std::string_view a, std::string_view b);

/// True if `name` consists of `head`, at least `digits` digits 0 to 9, and `tail`, as in
/// frame_00012.ply.
bool is_numbered(std::string_view name, std::string_view head, std::size_t digits,
                 std::string_view tail);

}  // namespace pointreel
