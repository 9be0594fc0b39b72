#include "codec/files/pcd.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <lzf.h>

#include "codec/files/named_fields.h"
#include "codec/files/ply_header.h"
#include "codec/files/words.h"
#include "common/base/concat.h"
#include "common/base/letter_case.h"
#include "common/base/parse_number.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// Far more than the header of any real file has.
constexpr std::size_t kMaxHeader = std::size_t{1} << 18;
constexpr std::size_t kMaxFields = 1024;
/// Of lines that are skipped.
constexpr std::size_t kMaxWarnings = 8;
constexpr std::uint64_t kMaxRecord = std::uint64_t{1} << 20;
/// Three bytes of LZF stand for at most 264.
constexpr std::uint64_t kLzfRatio = 90;

enum class Data : std::uint8_t { ascii, binary, compressed };

struct Field {
  std::string name;
  std::uint64_t size = 4, count = 1;  ///< of a number; of numbers
  char type = 'F';                    ///< I, U or F
};

struct PcdHeader {
  std::vector<Field> fields;
  std::optional<std::uint64_t> width, height, points;
  Data data = Data::ascii;
  std::size_t size = 0, lines = 0;
  bool moved = false;  ///< VIEWPOINT is not the origin
  std::vector<std::string> warnings;
};

Result<std::uint64_t> parse_count(std::string_view word, std::string_view keyword) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || value > 1ull << 40)
    return fail(concat(keyword, " has '", printable(word), "', which is not a count"));
  return value;
}

/// What follows FIELDS, SIZE, TYPE or COUNT: a word for each field.
template <class Set>
Result<void> parse_each(std::string_view rest, std::string_view keyword, PcdHeader& header,
                        const Set& set) {
  std::size_t at = 0;
  for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
    if (at == header.fields.size())
      return fail(concat(keyword, " has more entries than FIELDS, which has ", at));
    TRY(set(word, header.fields[at++]));
  }
  if (at < header.fields.size())
    return fail(concat(keyword, " has ", at, " entries, but FIELDS has ", header.fields.size()));
  return {};
}

Result<void> parse_fields(std::string_view rest, PcdHeader& header) {
  if (!header.fields.empty()) return fail("FIELDS stands there twice");
  for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
    if (header.fields.size() == kMaxFields)
      return fail(ErrorCode::limit, concat("more than ", kMaxFields, " fields"));
    header.fields.push_back({std::string(word)});
  }
  return {};
}

bool is_origin(std::string_view rest) {
  constexpr std::array<double, 7> kOrigin{0, 0, 0, 1, 0, 0, 0};  // a place and a quaternion
  for (const double expected : kOrigin) {
    double value = 0.0;
    if (!parse_number(take_word(rest), value) || value != expected) return false;
  }
  return true;
}

/// False if the keyword is unknown.
Result<bool> parse_line(std::string_view keyword, std::string_view rest, PcdHeader& header) {
  const auto known = [] { return true; };
  if (keyword == "FIELDS" || keyword == "COLUMNS") return parse_fields(rest, header).map(known);
  if (keyword == "SIZE" || keyword == "COUNT") {
    return parse_each(rest, keyword, header,
                      [&](std::string_view word, Field& field) -> Result<void> {
                        (keyword == "SIZE" ? field.size : field.count) =
                            TRY(parse_count(word, keyword));
                        return {};
                      })
        .map(known);
  }
  if (keyword == "TYPE") {
    return parse_each(rest, keyword, header,
                      [](std::string_view word, Field& field) -> Result<void> {
                        field.type = word[0];
                        if (word == "I" || word == "U" || word == "F") return {};
                        return fail(concat("TYPE has '", printable(word), "': expected I, U or F"));
                      })
        .map(known);
  }
  const std::string_view word = take_word(rest);
  if (keyword == "WIDTH") {
    header.width = TRY(parse_count(word, keyword));
  } else if (keyword == "HEIGHT") {
    header.height = TRY(parse_count(word, keyword));
  } else if (keyword == "POINTS") {
    header.points = TRY(parse_count(word, keyword));
  } else if (keyword == "DATA") {
    if (equal_in_any_case(word, "ascii")) {
      header.data = Data::ascii;
    } else if (equal_in_any_case(word, "binary")) {
      header.data = Data::binary;
    } else if (equal_in_any_case(word, "binary_compressed")) {
      header.data = Data::compressed;
    } else {
      return fail(
          concat("DATA is '", printable(word), "': expected ascii, binary or binary_compressed"));
    }
  } else if (keyword != "VERSION") {
    return false;
  }
  return true;
}

Result<PcdHeader> parse_header(std::string_view text) {
  PcdHeader header;
  Lines lines(text);
  for (std::string_view line; lines.next(line);) {
    std::string_view rest = line;
    const std::string keyword = in_capitals(take_word(rest));
    if (keyword.empty() || keyword[0] == '#') continue;
    const std::string place = concat("line ", lines.number());
    if (keyword == "VIEWPOINT") {
      header.moved = !is_origin(rest);
      continue;
    }
    const Result<bool> known = parse_line(keyword, rest, header);
    if (!known) return fail_at(place, known.error());
    if (!*known && header.warnings.size() < kMaxWarnings) {
      header.warnings.push_back(
          concat(place, ": is skipped: unknown keyword '", printable(keyword), "'"));
    }
    if (keyword != "DATA") continue;
    if (header.fields.empty()) return fail_at(place, Error{"DATA comes before FIELDS"});
    header.size = text.size() - lines.rest().size();
    header.lines = lines.number();
    return header;
  }
  return fail(concat("line ", lines.number(), ": the header has no line DATA"));
}

Result<std::uint64_t> count_of(const PcdHeader& header) {
  if (!header.width && !header.points) return fail("the header has neither WIDTH nor POINTS");
  // Each is below 2^41, and a height above 2^22 with it is no image.
  const std::uint64_t height = header.height.value_or(1);
  if (!header.width) return *header.points;
  if (height > 0 && *header.width > (std::uint64_t{1} << 41) / height)
    return fail(ErrorCode::limit, "WIDTH times HEIGHT is too large");
  const std::uint64_t product = *header.width * height;
  if (header.points && *header.points != product) {
    return fail(
        concat("the header says POINTS ", *header.points, ", but WIDTH times HEIGHT is ", product));
  }
  return product;
}

std::optional<NumberType> type_of(const Field& field) {
  const auto choose = [&](NumberType i, NumberType u) { return field.type == 'I' ? i : u; };
  switch (field.size) {
    case 1:
      if (field.type != 'F') return choose(NumberType::int8, NumberType::uint8);
      break;
    case 2:
      if (field.type != 'F') return choose(NumberType::int16, NumberType::uint16);
      break;
    case 4:
      if (field.type == 'F') return NumberType::float32;
      return choose(NumberType::int32, NumberType::uint32);
    case 8:
      if (field.type == 'F') return NumberType::float64;
      return choose(NumberType::int64, NumberType::uint64);
    default:
      break;
  }
  return std::nullopt;
}

/// What the data consist of.
struct Table {
  std::vector<NamedField> single;   ///< fields with one number
  std::vector<std::string> others;  ///< names of those with more
  std::uint64_t size = 0;           ///< of a point, in bytes
  std::uint64_t words = 0;          ///< of a point, in ascii
};

/// Offsets and strides are those of the data in a file of this kind with `count` points.
Result<Table> table_of(const PcdHeader& header, std::uint64_t count) {
  Table table;
  for (const Field& field : header.fields) {
    const std::optional<NumberType> type = type_of(field);
    if (!type) {
      return fail(concat("the field ", printable(field.name), " has the type ",
                         std::string_view(&field.type, 1), " of ", field.size,
                         " bytes, which does not exist"));
    }
    // Checked for each field, so that no sum overflows.
    if (field.count > kMaxRecord || table.size > kMaxRecord)
      return fail(ErrorCode::limit, "a point has more than 2^20 bytes");
    if (field.count == 1) {
      // Columns, unless the points follow each other. What does not fit is refused before it is
      // read.
      const bool columns = header.data == Data::compressed;
      table.single.push_back({field.name,
                              {static_cast<std::size_t>(table.size * (columns ? count : 1)),
                               columns ? size_of(*type) : 0, *type}});
    } else if (field.count > 1 && field.name != "_") {
      table.others.push_back(printable(field.name));
    }
    table.size += field.size * field.count;
    table.words += field.count;
  }
  if (table.size > kMaxRecord) return fail(ErrorCode::limit, "a point has more than 2^20 bytes");
  if (header.data == Data::binary) {
    for (NamedField& named : table.single)
      named.field.stride = static_cast<std::size_t>(table.size);
  }
  return table;
}

/// Reads columns that LZF has compressed.
Result<PointCloud> read_compressed(const ByteSource& source, const PcdHeader& header,
                                   const Table& table, const RecordLayout& layout,
                                   std::uint64_t count, ReadNotes& notes) {
  Bytes room;
  const ByteView sizes = TRY(source.view(header.size, 8, room));
  if (sizes.size() < 8)
    return fail(concat("byte ", source.size(), ": the data end within their sizes"));
  const auto packed = load_number<std::uint32_t>(sizes.data());
  const auto unpacked = load_number<std::uint32_t>(sizes.data() + 4);
  if (count * table.size != unpacked) {
    return fail(concat("byte ", header.size + 4, ": the columns take ", unpacked, " bytes, but ",
                       count, " points of ", table.size, " bytes need ", count * table.size));
  }
  if (unpacked > kLzfRatio * packed) {
    return fail(
        concat("byte ", header.size, ": ", packed, " bytes of LZF cannot stand for ", unpacked));
  }
  RecordCollector collector(layout, count);
  if (count == 0) return collector.finish(notes);
  const ByteView bytes = TRY(source.view(header.size + 8, packed, room));
  if (bytes.size() < packed)
    return fail(concat("byte ", header.size + 8 + bytes.size(), ": the compressed data end before ",
                       packed, " bytes"));
  Bytes columns(unpacked);
  if (lzf_decompress(bytes.data(), packed, columns.data(), unpacked) != unpacked)
    return fail(concat("byte ", header.size + 8, ": the compressed data are damaged"));
  collector.add(columns.data(), 0, static_cast<std::size_t>(count));
  return collector.finish(notes);
}

/// Colours in one number are written as a whole number, or as the float of the same bits.
bool is_whole(std::string_view word) {
  return !word.empty() && word.find_first_not_of("0123456789") == std::string_view::npos;
}

Result<PointCloud> read_ascii(const ByteSource& source, const PcdHeader& header, const Table& table,
                              std::uint64_t count, ReadNotes& notes) {
  // Words become records of those fields that have one number.
  std::vector<NamedField> fields = table.single;
  std::size_t size = 0;
  for (NamedField& named : fields) {
    named.field.offset = size;
    size += size_of(named.field.type);
  }
  for (NamedField& named : fields) named.field.stride = size;
  std::vector<std::string> ignored;
  const RecordLayout layout = TRY(layout_of(fields, ignored));
  const auto packed_color = layout.packed_color ? layout.packed_color->offset : size;

  Bytes room;
  const ByteView bytes = TRY(source.all(room));
  std::string_view text = text_of(bytes).substr(std::min(header.size, bytes.size()));
  const auto line_of = [&](std::string_view word) {
    const char* const begin = text_of(bytes).data() + header.size;
    return header.lines + 1 + static_cast<std::size_t>(std::count(begin, word.data(), '\n'));
  };
  RecordCollector collector(layout, std::min<std::uint64_t>(count, text.size() / table.words + 1));
  const std::size_t block = std::max<std::size_t>(1, (std::size_t{1} << 16) / size);
  Bytes records(block * size);
  std::size_t rows = 0;
  for (std::uint64_t row = 0; row < count; ++row) {
    std::uint8_t* const record = records.data() + rows * size;
    std::size_t single = 0;
    for (const Field& field : header.fields) {
      for (std::uint64_t i = 0; i < field.count; ++i) {
        const std::string_view word = take_word(text);
        if (word.empty()) {
          return fail(concat("line ", line_of(word), ": the data end before ",
                             printable(field.name), " of point ", row, " of ", count));
        }
        if (field.count > 1) continue;
        const RecordField& into = fields[single].field;
        double value = 0.0;
        if (!parse_number(word, value)) {
          return fail(concat("line ", line_of(word), ": ", printable(field.name), " of point ", row,
                             " is '", printable(word), "', which is not a number"));
        }
        const bool bits = into.offset == packed_color && is_whole(word);
        store_number(bits ? NumberType::uint32 : into.type, value, record + into.offset);
      }
      if (field.count == 1) ++single;
    }
    if (++rows == block || row + 1 == count) collector.add(records.data(), 0, rows);
    if (rows == block) rows = 0;
  }
  return collector.finish(notes);
}

}  // namespace

Result<PointCloud> read_pcd(const ByteSource& source, ReadNotes& notes) {
  Bytes room;
  PcdHeader header = TRY(parse_header(text_of(TRY(source.view(0, kMaxHeader, room)))));
  const std::uint64_t count = TRY(count_of(header));
  const Table table = TRY(table_of(header, count));
  const RecordLayout layout = TRY(layout_of(table.single, notes.unread));
  notes.unread.insert(notes.unread.end(), table.others.begin(), table.others.end());
  if (header.moved) notes.unread.push_back("VIEWPOINT");
  notes.warnings = std::move(header.warnings);
  switch (header.data) {
    case Data::ascii:
      return read_ascii(source, header, table, count, notes);
    case Data::binary:
      return read_records(source, {header.size, count, static_cast<std::size_t>(table.size)},
                          layout, notes);
    default:
      return read_compressed(source, header, table, layout, count, notes);
  }
}

}  // namespace pointreel
