#include "datasets_synthetic/ply_table.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>

namespace pointreel {
namespace {

template <class T>
std::string bytes_of(T value, bool big_endian) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// The shortest text that reads back as the same value. It is the same on every machine.
std::string word_of(PlyType type, double value) {
  switch (type) {
    case PlyType::float32:
      return fmt::format("{}", static_cast<float>(value));
    case PlyType::float64:
      return fmt::format("{}", value);
    default:
      return fmt::format("{}", static_cast<std::int64_t>(value));
  }
}

}  // namespace

void PlyTable::add_columns(PlyType type, const std::vector<std::string>& names) {
  for (const std::string& name : names) columns.push_back({type, name});
}

std::string_view name_of(PlyType type, bool sized) {
  constexpr std::array<std::array<std::string_view, 2>, 8> kNames{{{"char", "int8"},
                                                                   {"uchar", "uint8"},
                                                                   {"short", "int16"},
                                                                   {"ushort", "uint16"},
                                                                   {"int", "int32"},
                                                                   {"uint", "uint32"},
                                                                   {"float", "float32"},
                                                                   {"double", "float64"}}};
  return kNames[static_cast<std::size_t>(type)][sized ? 1 : 0];
}

std::string ply_begin(PlyFormat format, std::string_view line_end) {
  constexpr std::array<std::string_view, 3> kFormatWords{"ascii", "binary_little_endian",
                                                         "binary_big_endian"};
  return fmt::format("ply{1}format {0} 1.0{1}", kFormatWords[static_cast<std::size_t>(format)],
                     line_end);
}

std::string ply_declaration(const PlyTable& table, std::string_view count,
                            std::string_view line_end) {
  const std::string rows = fmt::format("{}", table.rows.size());
  std::string text =
      fmt::format("element {} {}{}", table.element, count.empty() ? rows : count, line_end);
  for (const PlyTable::Column& column : table.columns) {
    text += fmt::format("property {} {}{}", name_of(column.type), column.name, line_end);
  }
  return text;
}

std::string ply_value(PlyType type, PlyFormat format, double value) {
  const bool big = format == PlyFormat::big_endian;
  switch (type) {
    case PlyType::int8:
      return bytes_of(static_cast<std::int8_t>(value), big);
    case PlyType::uint8:
      return bytes_of(static_cast<std::uint8_t>(value), big);
    case PlyType::int16:
      return bytes_of(static_cast<std::int16_t>(value), big);
    case PlyType::uint16:
      return bytes_of(static_cast<std::uint16_t>(value), big);
    case PlyType::int32:
      return bytes_of(static_cast<std::int32_t>(value), big);
    case PlyType::uint32:
      return bytes_of(static_cast<std::uint32_t>(value), big);
    case PlyType::float32:
      return bytes_of(static_cast<float>(value), big);
    default:
      return bytes_of(value, big);
  }
}

std::string ply_rows(const PlyTable& table, PlyFormat format, std::string_view line_end) {
  std::string text;
  for (const std::vector<double>& row : table.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const PlyType type = table.columns[i].type;
      if (format == PlyFormat::ascii) {
        if (i > 0) text += ' ';
        text += word_of(type, row[i]);
      } else {
        text += ply_value(type, format, row[i]);
      }
    }
    if (format == PlyFormat::ascii) text += line_end;
  }
  return text;
}

std::string ply_text(const PlyTable& table, PlyFormat format, std::string_view line_end) {
  return fmt::format("{}{}end_header{}{}", ply_begin(format, line_end),
                     ply_declaration(table, {}, line_end), line_end,
                     ply_rows(table, format, line_end));
}

}  // namespace pointreel
