#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace pointreel {

using Bytes = std::vector<std::uint8_t>;
/// Bytes that belong to somebody else and must outlive the view.
using ByteView = std::span<const std::uint8_t>;

}  // namespace pointreel
