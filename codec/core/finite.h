#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include <glm/glm.hpp>

namespace pointreel {

static_assert(sizeof(glm::vec3) == 3 * sizeof(float));

/// Whether no coordinate is infinite or NaN. Compilers make vector instructions of it, as they do
/// not of std::isfinite.
inline bool are_finite(std::span<const glm::vec3> positions) {
  constexpr std::uint32_t kExponent = 0x7f800000;
  const auto* const at = reinterpret_cast<const unsigned char*>(positions.data());
  std::uint32_t found = 0;
  for (std::size_t i = 0; i < 3 * positions.size(); ++i) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, at + i * sizeof(bits), sizeof(bits));
    found |= (bits & kExponent) == kExponent ? 1u : 0u;
  }
  return found == 0;
}

}  // namespace pointreel
