#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "common/cloud/ply_header.h"
#include "pointreel/bytes.h"

namespace pointreel {

/// One element of a PLY file as a table of doubles, for files that a PointCloud cannot express:
/// every scalar type, every format, values that are no numbers. Knows nothing of attributes.
struct PlyTable {
  struct Column {
    PlyType type;
    std::string name;
  };
  std::string element = "vertex";
  std::vector<Column> columns;
  std::vector<std::vector<double>> rows;  ///< each as long as `columns`

  void add_columns(PlyType type, const std::vector<std::string>& names);
  /// As `add_columns`, with the values that a row gets appended by `values(row)`.
  template <class F>
  void add_columns(PlyType type, const std::vector<std::string>& names, F&& values) {
    add_columns(type, names);
    for (std::size_t row = 0; row < rows.size(); ++row) {
      for (const double value : values(row)) rows[row].push_back(value);
    }
  }
};

/// "ply" and the format line, each ended by `line_end`.
std::string ply_begin(PlyFormat format, std::string_view line_end = "\n");

/// The lines that declare the table's element, with `count` rows in place of those that it has if
/// one is given.
std::string ply_declaration(const PlyTable& table, std::string_view count = {},
                            std::string_view line_end = "\n");

/// The rows: numbers that read back exactly and a line for each row, or the values' bytes.
std::string ply_rows(const PlyTable& table, PlyFormat format, std::string_view line_end = "\n");

/// A value as the bytes of a type in a binary format.
std::string ply_value(PlyType type, PlyFormat format, double value);

/// The whole file.
std::string ply_text(const PlyTable& table, PlyFormat format, std::string_view line_end = "\n");

/// The name that a header gives a type: "float", or "float32" if `sized`.
std::string_view name_of(PlyType type, bool sized = false);

}  // namespace pointreel
