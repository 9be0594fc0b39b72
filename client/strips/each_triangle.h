#pragma once

#include <cstdint>
#include <span>

#include "client/strips/strip_order.h"

namespace pointreel {

/// Calls visit(a, b, c) for each triangle of whole strips, the way round that it has.
template <class Visit>
inline void each_triangle(std::span<const std::uint32_t> indices, const Visit& visit) {
  const std::uint32_t* at = indices.data();
  const std::uint32_t* const end = at + indices.size();
  while (end - at > 2) {
    std::uint32_t a = *at++, b = *at++;
    for (bool turned = false; *at != kEndOfStrip; turned = !turned) {
      const std::uint32_t c = *at++;
      visit(a, turned ? c : b, turned ? b : c);
      a = b;
      b = c;
    }
    ++at;
  }
}

}  // namespace pointreel
