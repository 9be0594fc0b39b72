#pragma once

#include <cstdint>

/// The binary form of glTF. Source: "glTF 2.0 Specification", section 4.4.
namespace pointreel {

inline constexpr std::uint32_t kGlbMagic = 0x46546c67;
inline constexpr std::uint32_t kGlbJson = 0x4e4f534a, kGlbBinary = 0x004e4942;  ///< types of chunks

}  // namespace pointreel
