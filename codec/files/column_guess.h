#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace pointreel {

/// Finds names for columns of numbers without any, by some of their rows.
class ColumnGuess {
 public:
  /// Columns that are looked at, and kept without names.
  static constexpr std::size_t kMost = 10;

  void begin() { before_.reset(); }  ///< of a file
  void see(const double* row, std::size_t columns);

  /// Whether the first column is one more in each row than in the one before.
  bool first_counts_rows() const;

  /// Of text; text_points.h says how. `pts`: as .pts files have them.
  std::vector<std::string> text_names(std::size_t columns, bool pts) const;
  /// Of the floats of sweeps; sweep.h says how.
  std::vector<std::string> sweep_names(std::size_t floats) const;

 private:
  struct Look {
    bool whole = true, bytes = true;  ///< whole numbers from 0 on, and up to 255
    bool negative = false;
    bool varies = false;
    double first = 0.0, most = 0.0;
    std::size_t unit = 0;  ///< rows in which this and the next two are a vector of length 1
  };

  // Of three columns from there on.
  bool are_bytes(std::size_t at) const;
  bool are_bright_bytes(std::size_t at) const;  ///< far beyond what classes and returns count
  bool are_unit(std::size_t at) const;
  bool are_normals(std::size_t at) const;

  /// A colour and a normal in either order, and an intensity if there are ten columns.
  void add_two_triples(std::vector<std::string>& names, std::size_t columns) const;

  std::array<Look, kMost> looks_{};
  std::size_t rows_ = 0;
  std::size_t counted_ = 0;  ///< rows whose first column is one more than that of the row before
  bool falls_ = false;       ///< the first column does, within a file
  std::optional<double> before_;  ///< the first column
};

}  // namespace pointreel
