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

/// The scalar types, whichever of their two names (char or int8, ...) the header uses.
enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// 1, 2, 4 or 8 bytes.
std::size_t size_of(PlyType type);

/// The beginning of a word from an untrusted file, fit to stand in a one-line message.
std::string printable(std::string_view word);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;  ///< of the scalar, or of a list's entries
  bool is_list = false;
  PlyType count_type = PlyType::uint8;  ///< of a list's length; an integer type
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;  ///< as declared: not yet compared with the data that is there
  std::vector<PlyProperty> properties;
  std::size_t line = 0;  ///< where the header declares it

  /// The property of that name, or -1.
  int find(const std::string& property) const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::size_t size = 0;   ///< bytes up to and with the line break after end_header
  std::size_t lines = 0;  ///< line breaks in them
};

/// Parses a PLY header (G. Turk, "The PLY Polygon File Format", 1994): lines that end in LF or CR
/// LF, comments and obj_info anywhere, words apart by blanks or tabs.
///
/// Trust: `bytes` may be anything. Takes memory in proportion to the header's own size; counts are
/// read, not believed. Errors begin with "line N: " and name the element or property.
Result<PlyHeader> parse_ply_header(ByteView bytes);

}  // namespace pointreel
