#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "client/scene/environment_map.h"
#include "pointreel/error.h"

namespace pointreel {

/// Reads an equirectangular picture in Radiance's format, .hdr (G. Ward, "Real Pixels", Graphics
/// Gems II, 1991): RGBE, flat or with run-length encoding of components, rows from top to bottom
/// and pixels from left to right. Large pictures are reduced while they are read: light needs no
/// more than kMostEnvironmentRows rows. Fails with ErrorCode::invalid, unsupported or limit.
///
/// Trust: the bytes may be hostile. Memory is bounded by kMostEnvironmentRows, and time by the
/// number of pixels that the header gives, which the bytes must have.
Result<EnvironmentMap> parse_radiance(std::span<const std::uint8_t> bytes);

inline constexpr int kMostEnvironmentRows = 256;
/// The largest width; the largest height is half of it.
inline constexpr int kMostRadianceWidth = 16384;

/// Reads such a file of at most 256 MiB. Errors name the file.
Result<EnvironmentMap> load_environment(const std::string& file);

}  // namespace pointreel
