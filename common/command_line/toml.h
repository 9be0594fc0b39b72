#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pointreel/error.h"

namespace pointreel::cli {

/// A line NAME = VALUE of a file in TOML.
struct TomlSetting {
  std::string table;  ///< the name in the brackets above; empty if there are none
  std::string name;
  std::vector<std::string> values;  ///< of a list its elements
  bool is_flag = false;             ///< the value is true or false
  int line = 0;                     ///< from 1 on
};

/// Reads a file of up to 1 MiB that has tables of plain values and of lists of these. Errors name a
/// line, and nothing that stands in it, because it may be a token.
///
/// Trust: `text` may be anything; toml++ parses it.
Result<std::vector<TomlSetting>> parse_toml(std::string_view text);

}  // namespace pointreel::cli
