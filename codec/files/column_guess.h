#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace pointreel {

/// Finds names for columns of numbers without any, by some of their rows.
class ColumnGuess {
 public:
  /// Columns that are looked at, and kept without names.
  static constexpr std::size_t kMost = 10;

  void see(const double* row, std::size_t columns);

  /// Of text; text_points.h says how. `pts`: as .pts files have them.
  std::vector<std::string> text_names(std::size_t columns, bool pts) const;
  /// Of the floats of sweeps; sweep.h says how.
  std::vector<std::string> sweep_names(std::size_t floats) const;

 private:
  struct Look {
    bool whole = true, bytes = true;  ///< whole numbers from 0 on, and up to 255
    bool negative = false;
    bool varies = false;
    double first = 0.0;
  };

  bool are_bytes(std::size_t at) const;  ///< three columns from there on
  bool are_normals() const;              ///< columns 4 to 6

  std::array<Look, kMost> looks_{};
  std::size_t unit_ = 0, rows_ = 0;
};

}  // namespace pointreel
