#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "codec/files/ply_header.h"
#include "pointreel/bytes.h"

namespace pointreel {

/// One element of a PLY file as a table of doubles, for files that a PointCloud cannot express:
/// every scalar type, every format, NaN and infinity. The columns have names but no meaning.
struct PlyTable {
  struct Column {
    PlyType type;
    std::string name;
  };
  std::string element = "vertex";
  std::vector<Column> columns;
  std::vector<std::vector<double>> rows;  ///< each as long as `columns`

  void add_columns(PlyType type, const std::vector<std::string>& names);
  /// Adds columns and appends the values that `values(row)` returns to each row.
  template <class F>
  void add_columns(PlyType type, const std::vector<std::string>& names, F&& values) {
    add_columns(type, names);
    for (std::size_t row = 0; row < rows.size(); ++row) {
      for (const double value : values(row)) rows[row].push_back(value);
    }
  }
};

/// "ply" and the format line, each followed by `line_end`.
std::string ply_begin(PlyFormat format, std::string_view line_end = "\n");

/// The lines that declare the table's element. `count`, unless empty, replaces the true number of
/// rows.
std::string ply_declaration(const PlyTable& table, std::string_view count = {},
                            std::string_view line_end = "\n");

/// The rows: in ascii a line for each row with numbers that read back exactly, else the bytes of
/// the values.
std::string ply_rows(const PlyTable& table, PlyFormat format, std::string_view line_end = "\n");

/// The bytes of a value in a binary format.
std::string ply_value(PlyType type, PlyFormat format, double value);

/// The whole file.
std::string ply_text(const PlyTable& table, PlyFormat format, std::string_view line_end = "\n");

/// The name of a type in a header: "float", or "float32" if `sized`.
std::string_view name_of(PlyType type, bool sized = false);

}  // namespace pointreel
