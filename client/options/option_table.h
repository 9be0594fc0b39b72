#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "client/options/settings.h"

namespace pointreel {

/// The numbers from `min` to `max`, both included.
struct Range {
  double min = 0.0, max = 0.0;

  bool contains(double number) const { return number >= min && number <= max; }  // never NaN
};

/// A member of Settings as the user meets it: on the command line of `pointreel play` and in its
/// --help, in the settings file, and in the drawing panel. All of them are made from this table, so
/// a new option is a row in it.
struct Option {
  /// Reads the value from settings and changes it in them.
  template <class T>
  struct Access {
    T (*get)(const Settings&);
    void (*set)(Settings&, T);
  };
  struct Flag : Access<bool> {};
  struct Number : Access<double> {
    Range range;
    // In the panel. A slider may show less than the range.
    Range slider;
    const char* format = "";  ///< of the number beside the slider, as for printf
    bool logarithmic = false;
  };
  /// One of several names; the value is its index.
  struct Choice : Access<std::size_t> {
    std::vector<const char*> names;
    std::vector<const char*> labels;  ///< of a row of buttons in the panel; empty: a list of names
  };
  struct Color : Access<glm::vec3> {};  ///< sRGB, 0 to 1
  struct Size : Access<glm::ivec2> {
    Range range;  ///< of each side, in pixels
  };

  std::string_view name;  ///< in the settings file: "point_size"
  std::variant<Flag, Number, Choice, Color, Size> value;
  std::string_view help = {};          ///< in --help; empty: not an option of the command line
  const char* label = nullptr;         ///< in the drawing panel; null: not there
  const char* tip = nullptr;           ///< in the drawing panel; null: none
  std::string_view group = "Drawing";  ///< heading in --help
  /// An earlier name, which is still read but no longer shown or written.
  std::string_view old_name = {};
};

std::span<const Option> option_table();

/// The option of that name, which the table must have.
const Option& find_option(std::string_view name);

/// "--point-size" for the name "point_size".
std::string command_line_name(std::string_view name);

void copy_value(const Option& option, const Settings& from, Settings& to);

}  // namespace pointreel
