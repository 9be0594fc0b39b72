#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace pointreel {

using Bytes = std::vector<std::uint8_t>;
/// Bytes that belong to somebody else and must outlive the view.
using ByteView = std::span<const std::uint8_t>;

/// XXH3 with 64 bits and seed 0. Manifests write it as 16 lowercase hexadecimal digits.
std::uint64_t checksum_of(ByteView bytes);

}  // namespace pointreel
