#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

enum class PlyFormat { ascii, little_endian, big_endian };

/// The scalar types. Each has two names in headers, such as char and int8.
enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// The size of a value in a binary file: 1, 2, 4 or 8 bytes.
std::size_t size_of(PlyType type);

/// A word from an untrusted file in a form that fits into a one-line message: shortened, and
/// without control characters.
std::string printable(std::string_view word);
/// The same of a name, which may be empty.
std::string printable_name(std::string_view name);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;  ///< the type of the scalar, or of a list's entries
  bool is_list = false;
  PlyType count_type = PlyType::uint8;  ///< the type of a list's length; an integer type
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;  ///< as declared, not yet compared with the size of the data
  std::vector<PlyProperty> properties;
  std::size_t line = 0;  ///< the line of the header that declares it

  /// The index of the property of that name, or -1.
  int find(std::string_view property) const;
  /// The same, but if there is none, of the first whose name differs by case alone.
  int find_any_case(std::string_view property) const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::size_t size = 0;   ///< in bytes, including the line break after end_header
  std::size_t lines = 0;  ///< number of lines
  char line_end = '\n';   ///< what the last character of a line is
  std::vector<std::string> warnings;
};

/// Parses a PLY header (G. Turk, "The PLY Polygon File Format", 1994). Lines may end in LF, CR LF
/// or CR, words are separated by blanks or tabs, and comments and obj_info may stand anywhere. Case
/// does not matter in keywords, types and names of elements, which are kept in small letters; names
/// of properties are kept as they are. Lines with unknown keywords are skipped with a warning.
/// Errors begin with "line N: " and name the element or property.
///
/// Trust: the bytes may be hostile. Memory is proportional to the size of the header; no memory is
/// taken for the counts that it declares.
Result<PlyHeader> parse_ply_header(ByteView bytes);

}  // namespace pointreel
