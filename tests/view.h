#pragma once

#include <cstdint>
#include <string>

#include "pointreel/bytes.h"

namespace pointreel {

/// The bytes of a text.
inline ByteView view(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace pointreel
