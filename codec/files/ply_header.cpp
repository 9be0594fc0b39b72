#include "codec/files/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <utility>

#include "codec/files/words.h"
#include "common/base/concat.h"
#include "common/base/letter_case.h"

namespace pointreel {
namespace {

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypeNames{{
    {"char", PlyType::int8},
    {"int8", PlyType::int8},
    {"uchar", PlyType::uint8},
    {"uint8", PlyType::uint8},
    {"short", PlyType::int16},
    {"int16", PlyType::int16},
    {"ushort", PlyType::uint16},
    {"uint16", PlyType::uint16},
    {"int", PlyType::int32},
    {"int32", PlyType::int32},
    {"uint", PlyType::uint32},
    {"uint32", PlyType::uint32},
    {"float", PlyType::float32},
    {"float32", PlyType::float32},
    {"double", PlyType::float64},
    {"float64", PlyType::float64},
}};

/// Far more than any real file has. They bound the time of searching for duplicate names.
constexpr std::size_t kMaxElements = 256;
constexpr std::size_t kMaxProperties = 4096;
/// Of lines that are skipped.
constexpr std::size_t kMaxWarnings = 8;

std::vector<std::string_view> split(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r\v\f";
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(kBlanks); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

/// Some programs write "comment:", or "#" as other formats have it.
bool is_comment(std::string_view keyword) {
  return keyword.empty() || keyword.starts_with("comment") || keyword.starts_with("obj_info") ||
         keyword.starts_with("#");
}

bool parse_type(std::string_view name, PlyType& type) {
  const auto found = std::find_if(kTypeNames.begin(), kTypeNames.end(), [name](const auto& entry) {
    return equal_in_any_case(entry.first, name);
  });
  if (found == kTypeNames.end()) return false;
  type = found->second;
  return true;
}

using Words = std::vector<std::string_view>;

Result<void> parse_format(const Words& words, PlyHeader& header) {
  const std::string name = in_small_letters(words.size() > 1 ? words[1] : std::string_view());
  if (name == "ascii") {
    header.format = PlyFormat::ascii;
  } else if (name == "binary_little_endian") {
    header.format = PlyFormat::little_endian;
  } else if (name == "binary_big_endian") {
    header.format = PlyFormat::big_endian;
  } else {
    return fail(concat("unknown format '", printable(name),
                       "': expected ascii, binary_little_endian or binary_big_endian"));
  }
  return {};
}

Result<void> parse_element(const Words& words, PlyHeader& header) {
  if (words.size() < 3) return fail("an element needs a name and a count");
  if (header.elements.size() == kMaxElements) {
    return fail(ErrorCode::limit, concat("more than ", kMaxElements, " elements"));
  }
  PlyElement element;
  element.name = in_small_letters(words[1]);
  const std::string_view count = words[2];
  const auto [end, error] =
      std::from_chars(count.data(), count.data() + count.size(), element.count);
  if (error != std::errc() || end != count.data() + count.size()) {
    return fail(concat("element ", printable(words[1]), " has the count '", printable(count),
                       "', which is not a number of rows"));
  }
  for (const PlyElement& other : header.elements) {
    if (other.name == element.name) {
      return fail(concat("element ", printable(words[1]), " is declared twice"));
    }
  }
  header.elements.push_back(std::move(element));
  return {};
}

Result<void> parse_property(const Words& words, PlyHeader& header) {
  if (header.elements.empty()) return fail("a property stands before the first element");
  PlyElement& element = header.elements.back();
  if (element.properties.size() == kMaxProperties) {
    return fail(ErrorCode::limit, concat("element ", printable(element.name), " has more than ",
                                         kMaxProperties, " properties"));
  }
  PlyProperty property;
  property.is_list = words.size() > 1 && equal_in_any_case(words[1], "list");
  const std::size_t wanted = property.is_list ? 5 : 3;
  if (words.size() < wanted) {
    return fail(
        concat("a property of element ", printable(element.name), " lacks its type or name"));
  }
  property.name = words[wanted - 1];
  if (!parse_type(words[wanted - 2], property.type)) {
    return fail(concat("property ", printable(property.name), " has the unknown type '",
                       printable(words[wanted - 2]), "'"));
  }
  if (property.is_list &&
      (!parse_type(words[2], property.count_type) || property.count_type >= PlyType::float32)) {
    return fail(concat("list property ", printable(property.name), " counts its entries in '",
                       printable(words[2]), "', which is not an integer type"));
  }
  if (element.find(property.name) >= 0) {
    return fail(concat("property ", printable(property.name), " of element ",
                       printable(element.name), " is declared twice"));
  }
  element.properties.push_back(std::move(property));
  return {};
}

}  // namespace

std::string printable(std::string_view word) {
  constexpr std::size_t kLimit = 40;
  std::string text(word.substr(0, kLimit));
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  return word.size() > kLimit ? text + "..." : text;
}

std::string printable_name(std::string_view name) {
  return name.empty() ? "(unnamed)" : printable(name);
}

std::size_t size_of(PlyType type) {
  constexpr std::array<std::size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

int PlyElement::find(std::string_view property) const {
  for (std::size_t i = 0; i < properties.size(); ++i) {
    if (properties[i].name == property) return static_cast<int>(i);
  }
  return -1;
}

int PlyElement::find_any_case(std::string_view property) const {
  if (const int exact = find(property); exact >= 0) return exact;
  for (std::size_t i = 0; i < properties.size(); ++i) {
    if (equal_in_any_case(properties[i].name, property)) return static_cast<int>(i);
  }
  return -1;
}

Result<PlyHeader> parse_ply_header(ByteView bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  PlyHeader header;
  if (text.starts_with(kUtf8Mark)) header.size = kUtf8Mark.size();
  if (!equal_in_any_case(text.substr(header.size, 3), "ply")) return fail("line 1: not a PLY file");
  // The first line tells how all of them end: after CR alone, data may begin with LF.
  const std::size_t first_end = std::min(text.find_first_of("\r\n"), text.size());
  if (text.substr(first_end, 1) == "\r" && text.substr(first_end, 2) != "\r\n")
    header.line_end = '\r';
  bool has_format = false;
  while (true) {
    const std::size_t end = text.find(header.line_end, header.size);
    // The last line may lack a line break if no data follow it.
    const Words words = split(text.substr(header.size, end - header.size));
    header.size = end == std::string_view::npos ? text.size() : end + 1;
    ++header.lines;
    const std::string place = concat("line ", header.lines);
    const std::string keyword = in_small_letters(words.empty() ? std::string_view() : words[0]);

    Result<void> parsed;
    if (header.lines == 1) {
      if (keyword != "ply" || words.size() != 1) return fail("line 1: not a PLY file");
    } else if (keyword == "end_header") {
      if (!has_format) return fail_at(place, Error{"the header ends without a format"});
      return header;
    } else if (keyword == "format") {
      parsed = parse_format(words, header);
      has_format = true;
    } else if (keyword == "element") {
      parsed = parse_element(words, header);
      if (parsed) header.elements.back().line = header.lines;
    } else if (keyword == "property") {
      parsed = parse_property(words, header);
    } else if (!is_comment(keyword) && header.warnings.size() < kMaxWarnings) {
      header.warnings.push_back(
          concat(place, ": is skipped: unknown keyword '", printable(words[0]), "'"));
    }
    if (!parsed) return fail_at(place, parsed.error());
    if (end == std::string_view::npos) {
      return fail_at(place, Error{"the file ends before the header's end_header"});
    }
  }
}

}  // namespace pointreel
