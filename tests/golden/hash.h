#pragma once

#include <string>
#include <vector>

#include <fmt/format.h>
#include <xxhash.h>

namespace pointreel::golden {

/// The bytes of these values, in 16 hexadecimal digits.
template <class T>
std::string hash(const std::vector<T>& values) {
  return fmt::format("{:016x}", XXH3_64bits(values.data(), values.size() * sizeof(T)));
}

}  // namespace pointreel::golden
