#pragma once

#include <cstdint>
#include <string>

#include <fmt/format.h>

namespace pointreel {

/// The name of a layer's file, as in 00000030.base.511922c5.prs: the number of the segment's first
/// frame, the layer, and the first half of the checksum.
inline std::string layer_file_name(std::uint32_t first_frame, const std::string& layer,
                                   std::uint64_t checksum) {
  return fmt::format("{:08}.{}.{:08x}.prs", first_frame, layer, checksum >> 32);
}

}  // namespace pointreel
