#pragma once

#include <optional>
#include <string>
#include <vector>

namespace pointreel {

/// How files are read that do not tell it themselves: alike for all frames of a sequence.
struct Reading {
  /// Names of the columns of text, or of the floats of a sweep's points, in their order, as
  /// named_fields.h knows them; "_" is skipped. Empty: by the file.
  std::vector<std::string> columns;
  /// What stands for full brightness in colours whose type does not tell it (full_color.h): 1, 255
  /// or 65535, or 0: by the file.
  double full_color = 0.0;
  /// Scalar fields, such as a classification, that are left out of frames in which they are the
  /// same at all points. Nothing: by the file.
  std::optional<std::vector<std::string>> omit_constant = {};
};

}  // namespace pointreel
