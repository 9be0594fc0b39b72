#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// The ways to mirror a cube and to exchange its axes. A surface looks much the same from all
/// sides, so contexts are found for neighbourhoods that were turned to a common orientation, and
/// masks are turned along. FORMAT.md, "Orientation".
namespace pointreel {

/// Bits 0 to 2: whether x, y, z are mirrored. Bits 3 to 5: whether, afterwards, x and y, then y and
/// z, then x and y again are exchanged. Several numbers may stand for the same orientation.
using Orientation = std::uint8_t;

namespace orientation {

inline constexpr std::size_t kCount = 64;

/// The number of a child (x lowest) once it is turned.
constexpr unsigned turned_child(unsigned child, unsigned orientation) {
  unsigned x = (child ^ orientation) & 1u, y = (child ^ orientation) >> 1 & 1u,
           z = (child ^ orientation) >> 2 & 1u;
  const auto exchange = [](unsigned& a, unsigned& b) {
    const unsigned kept = a;
    a = b;
    b = kept;
  };
  if ((orientation & 8u) != 0) exchange(x, y);
  if ((orientation & 16u) != 0) exchange(y, z);
  if ((orientation & 32u) != 0) exchange(x, y);
  return x | y << 1 | z << 2;
}

using Masks = std::array<std::array<std::uint8_t, 256>, kCount>;

/// Not constexpr: compilers would take seconds for it in each source that includes this.
inline Masks make_masks(bool back) {
  Masks all{};
  for (unsigned o = 0; o < kCount; ++o) {
    for (unsigned child = 0; child < 8; ++child) {
      const unsigned turned = turned_child(child, o);
      const unsigned from = back ? turned : child, to = back ? child : turned;
      // The masks up to this child's bit are those without it, and once more with it.
      for (unsigned mask = 1u << from; mask < 256; ++mask) {
        if ((mask >> from & 1u) != 0) {
          all[o][mask] = static_cast<std::uint8_t>(all[o][mask] | 1u << to);
        }
      }
    }
  }
  return all;
}

/// Masks by orientation, turned and turned back.
inline const Masks kTurned = make_masks(false);
inline const Masks kTurnedBack = make_masks(true);

}  // namespace orientation
}  // namespace pointreel
