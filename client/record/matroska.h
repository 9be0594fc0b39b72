#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace pointreel {

// Raw pictures with the exact times at which they begin, in the container that carries both through
// a pipe: Matroska (RFC 9559), of unknown length, with one track of uncompressed RGB, 8 bits a
// channel, and times in microseconds.

/// What comes before the first picture.
std::string matroska_head(std::uint32_t width, std::uint32_t height);
/// What comes before the bytes of each picture.
std::string matroska_picture_head(std::uint64_t time_us, std::size_t picture_bytes);

}  // namespace pointreel
