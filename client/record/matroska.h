#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace pointreel {

// Writes raw pictures and the exact times at which they begin as Matroska (RFC 9559), a container
// that carries both through a pipe. The stream has unknown length, one track of uncompressed RGB
// with 8 bits per channel, and times in microseconds.

/// How long a picture is said to last if none comes behind it.
inline constexpr std::uint64_t kPictureUs = 20'000;

/// The bytes before the first picture.
std::string matroska_head(std::uint32_t width, std::uint32_t height);
/// The bytes before those of each picture.
std::string matroska_picture_head(std::uint64_t time_us, std::size_t picture_bytes);

}  // namespace pointreel
