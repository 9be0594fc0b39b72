#pragma once

#include <cstdint>

#include <glm/glm.hpp>

namespace pointreel {

/// The finest level of an octree: 21 bits an axis, so that a key fits 63 bits.
inline constexpr int kMaxDepth = 21;

/// Interleaves three coordinates below 2^21: bit i of x, y, z becomes bit 3i, 3i + 1, 3i + 2 of the
/// key. The child of a node that a key enters at the next level is therefore the key's next three
/// bits, x lowest, which is also the bit that the child has in its parent's mask.
std::uint64_t morton_encode(const glm::uvec3& cell);

/// The inverse of morton_encode.
glm::uvec3 morton_decode(std::uint64_t key);

}  // namespace pointreel
