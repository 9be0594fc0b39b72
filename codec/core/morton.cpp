#include "codec/core/morton.h"

namespace pointreel {
namespace {

/// Moves bit 3i to bit i and drops all others.
std::uint32_t compact(std::uint64_t v) {
  v &= 0x1249249249249249u;
  v = (v | v >> 2) & 0x10c30c30c30c30c3u;
  v = (v | v >> 4) & 0x100f00f00f00f00fu;
  v = (v | v >> 8) & 0x001f0000ff0000ffu;
  v = (v | v >> 16) & 0x001f00000000ffffu;
  v = (v | v >> 32) & 0x00000000001fffffu;
  return static_cast<std::uint32_t>(v);
}

}  // namespace

glm::uvec3 morton_decode(std::uint64_t key) {
  return {compact(key), compact(key >> 1), compact(key >> 2)};
}

}  // namespace pointreel
