#pragma once

#include <cstdint>

#include "pointreel/bytes.h"

namespace pointreel {

/// Of the header of a live stream's binary message, up to this checksum: PROTOCOL.md, "Live".
inline std::uint32_t header_checksum(ByteView header) {
  return static_cast<std::uint32_t>(checksum_of(header));
}

}  // namespace pointreel
