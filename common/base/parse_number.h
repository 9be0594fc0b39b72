#pragma once

#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>

#include "common/base/parse_double.h"

namespace pointreel {

/// Reads a word from a file that is a number and nothing else, perhaps with a plus. What a double
/// cannot hold becomes infinite or zero.
inline bool parse_number(std::string_view word, double& value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const char* const word_end = word.data() + word.size();
  const auto [end, error] = parse_double(word.data(), word_end, value);
  if (error == std::errc::result_out_of_range && end == word_end) {
    value = std::strtod(std::string(word).c_str(), nullptr);
    return true;
  }
  return error == std::errc() && end == word_end;
}

}  // namespace pointreel
