#include "codec/files/numpy.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <glm/gtc/packing.hpp>
#include <zip.h>

#include "codec/files/named_fields.h"
#include "codec/files/numpy_header.h"
#include "codec/files/ply_header.h"
#include "codec/files/records.h"
#include "codec/files/words.h"
#include "common/base/concat.h"
#include "common/base/letter_case.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::size_t kMostArrays = 256, kZipChunk = std::size_t{1} << 20;
/// Bytes that a point takes until it is encoded. An archive's size says nothing about them.
constexpr std::uint64_t kPointMemory = 64;
/// Rows that are looked at to guess what the columns are.
constexpr std::uint64_t kLookedRows = 4096;

constexpr std::array<std::string_view, 13> kPositionArrays{
    "positions", "position", "points",      "point",       "xyz", "pos",  "vertices",
    "coords",    "pts",      "coordinates", "point_cloud", "pcd", "cloud"};
constexpr std::array<std::string_view, 8> kColorArrays{
    "colors", "color", "colours", "colour", "rgb", "rgba", "point_colors", "vertex_colors"};
constexpr std::array<std::string_view, 4> kNormalArrays{"normals", "normal", "point_normals",
                                                        "vertex_normals"};

template <std::size_t kCount>
bool is_called(std::string_view name, const std::array<std::string_view, kCount>& names) {
  return std::any_of(names.begin(), names.end(),
                     [&](std::string_view other) { return equal_in_any_case(name, other); });
}

/// A file that is one array, or a zip archive of several.
class NumpyArrays {
 public:
  static Result<NumpyArrays> open(ByteView bytes) {
    NumpyArrays arrays;
    if (!text_of(bytes).starts_with("PK")) {
      arrays.single_ = bytes;
      arrays.names_.emplace_back("positions");
      return arrays;
    }
    zip_error_t error;
    zip_error_init(&error);
    zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
    zip_t* zip = source == nullptr ? nullptr : zip_open_from_source(source, ZIP_RDONLY, &error);
    const std::string why = zip == nullptr ? zip_error_strerror(&error) : "";
    zip_error_fini(&error);
    if (zip == nullptr) {
      if (source != nullptr) zip_source_free(source);
      return fail(concat("is a zip archive that cannot be read: ", why));
    }
    arrays.zip_.reset(zip);
    const auto entries =
        static_cast<std::uint64_t>(std::max<zip_int64_t>(zip_get_num_entries(zip, 0), 0));
    if (entries > kMostArrays) return fail(concat("has ", entries, " arrays, which are too many"));
    for (std::uint64_t i = 0; i < entries; ++i) {
      const char* name = zip_get_name(zip, i, ZIP_FL_ENC_RAW);
      arrays.names_.emplace_back(name == nullptr ? "" : name);
    }
    return arrays;
  }

  bool is_archive() const { return zip_ != nullptr; }
  std::size_t size() const { return names_.size(); }
  const std::string& name(std::size_t i) const { return names_[i]; }

  /// The first `count` bytes of an array; fewer where it ends before.
  Result<Bytes> begin(std::size_t i, std::uint64_t count) const {
    if (zip_ == nullptr) {
      const auto end = std::min<std::uint64_t>(count, single_.size());
      return Bytes(single_.begin(), single_.begin() + static_cast<std::ptrdiff_t>(end));
    }
    const std::unique_ptr<zip_file_t, decltype(&zip_fclose)> file(zip_fopen_index(zip_.get(), i, 0),
                                                                  zip_fclose);
    if (file == nullptr) return fail(concat("cannot be unpacked: ", zip_strerror(zip_.get())));
    Bytes bytes;
    while (bytes.size() < count) {
      const std::size_t had = bytes.size();
      const auto more = static_cast<std::size_t>(std::min<std::uint64_t>(kZipChunk, count - had));
      bytes.resize(had + more);
      const zip_int64_t got = zip_fread(file.get(), bytes.data() + had, more);
      if (got < 0) return fail("is damaged: it cannot be unpacked");
      bytes.resize(had + static_cast<std::size_t>(got));
      if (got == 0) break;
    }
    return bytes;
  }

 private:
  NumpyArrays() = default;

  struct Discard {
    void operator()(zip_t* zip) const { zip_discard(zip); }
  };
  std::vector<std::string> names_;
  ByteView single_;
  std::unique_ptr<zip_t, Discard> zip_;
};

/// An array whose rows may belong to points.
struct NumpyTable {
  std::size_t index = 0;  ///< among NumpyArrays
  std::string name;
  NumpyHeader header;
  std::uint64_t rows = 0;
  std::size_t columns = 1;  ///< numbers of a row; of a structured array, 1

  bool structured() const {
    return header.columns.size() > 1 || !header.columns.front().name.empty();
  }
  /// Few rows of many numbers are x, y and z of points that stand in columns.
  bool is_transposed() const { return rows <= 4 && columns > 16; }
  /// A few numbers in a square are more often those of a camera.
  bool is_small_matrix() const { return rows == columns && rows <= 4; }
  bool may_be_positions() const {
    return !structured() && columns >= 3 && !is_transposed() && header.columns.front().readable;
  }
  std::string text() const { return concat(printable_name(name), " ", header.shape_text()); }
};

/// Nothing if it has objects, no rows, or rows of rows.
std::optional<NumpyTable> numpy_table(std::size_t index, std::string name, NumpyHeader header) {
  std::vector<std::uint64_t> shape = header.shape;
  if (header.is_pickled()) return std::nullopt;
  while (shape.size() > 2 && shape.front() == 1) shape.erase(shape.begin());
  NumpyTable table{index, std::move(name), std::move(header)};
  if (shape.empty() || shape.size() > 2) return std::nullopt;
  table.rows = shape[0];
  constexpr std::uint64_t kMostColumns = 256;
  if (shape.size() == 2) {
    if (shape[1] == 0 || shape[1] > kMostColumns || table.structured()) return std::nullopt;
    table.columns = static_cast<std::size_t>(shape[1]);
  }
  return table;
}

bool has_names(const NumpyTable& table, std::initializer_list<std::string_view> names) {
  return std::all_of(names.begin(), names.end(), [&](std::string_view name) {
    return std::any_of(
        table.header.columns.begin(), table.header.columns.end(),
        [&](const NumpyColumn& column) { return equal_in_any_case(column.name, name); });
  });
}

/// What is in a file.
struct NumpyContents {
  NumpyArrays arrays;
  std::vector<NumpyTable> tables = {};
  std::vector<std::string> other_names = {};  ///< of what is no table, with shapes
  std::size_t positions = 0;                  ///< of the tables, the one that has them
};

/// The table with the positions; `tables.size()` if there is none, or if there are `several`
/// without a name that tells.
std::size_t find_positions(const std::vector<NumpyTable>& tables, bool& several) {
  for (const std::string_view name : kPositionArrays) {
    for (std::size_t i = 0; i < tables.size(); ++i)
      if (tables[i].may_be_positions() && equal_in_any_case(tables[i].name, name)) return i;
  }
  std::size_t found = tables.size();
  const auto any = [&](const char* letter) {
    const auto at = std::find_if(tables.begin(), tables.end(), [&](const NumpyTable& table) {
      return table.columns == 1 && !table.structured() && equal_in_any_case(table.name, letter);
    });
    return static_cast<std::size_t>(at - tables.begin());
  };
  if (std::max({any("x"), any("y"), any("z")}) < tables.size()) return any("x");
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const NumpyTable& table = tables[i];
    const bool named =
        table.structured() && (has_names(table, {"x", "y", "z"}) ||
                               std::any_of(table.header.columns.begin(), table.header.columns.end(),
                                           [](const NumpyColumn& column) {
                                             return column.count == 3 &&
                                                    is_called(column.name, kPositionArrays);
                                           }));
    const bool likely = table.may_be_positions() && !is_called(table.name, kColorArrays) &&
                        !is_called(table.name, kNormalArrays) &&
                        (tables.size() == 1 || !table.is_small_matrix());
    if (!named && !likely) continue;
    several |= found < tables.size();
    found = i;
  }
  return several ? tables.size() : found;
}

Result<NumpyContents> look_into(ByteView bytes) {
  NumpyContents contents{TRY(NumpyArrays::open(bytes))};
  std::string all;
  for (std::size_t i = 0; i < contents.arrays.size(); ++i) {
    std::string name = contents.arrays.name(i);
    if (contents.arrays.is_archive() && !name.ends_with(".npy")) {
      contents.other_names.push_back(printable_name(name));
      continue;
    }
    if (contents.arrays.is_archive()) name.erase(name.size() - 4);
    const auto at_array = [&](const Error& error) {
      return fail(error.code, contents.arrays.is_archive()
                                  ? concat(printable_name(name), ": ", error.message)
                                  : error.message);
    };
    const Result<Bytes> begin = contents.arrays.begin(i, kNumpyHeader);
    if (!begin) return at_array(begin.error());
    Result<NumpyHeader> header = read_numpy_header(*begin);
    if (!header) return at_array(header.error());
    const std::string shape = header->shape_text() + (header->is_pickled() ? " of objects" : "");
    all += concat(all.empty() ? "" : ", ", printable_name(name), " ", shape);
    if (auto table = numpy_table(i, name, std::move(*header))) {
      contents.tables.push_back(std::move(*table));
    } else {
      contents.other_names.push_back(concat(printable_name(name), " ", shape));
    }
  }
  bool several = false;
  contents.positions = find_positions(contents.tables, several);
  if (several) {
    return fail(
        concat("has several arrays that may be positions; call one of them positions, "
               "points or xyz: it has ",
               all));
  }
  if (contents.positions == contents.tables.size()) {
    return fail(
        concat("has no array of positions, of the shape (N, 3) and called positions, "
               "points or xyz: it has ",
               all.empty() ? "none" : all));
  }
  return contents;
}

/// The names of the numbers of a row, as those of the columns of text.
std::vector<std::string> row_names(const std::string& array, std::size_t columns, bool positions) {
  if (columns == 1) return {array};
  std::vector<std::string> names;
  if (positions) {
    names = {"x", "y", "z"};
  } else if (is_called(array, kColorArrays) && (columns == 3 || columns == 4)) {
    names = {"red", "green", "blue", "alpha"};
  } else if (is_called(array, kNormalArrays) && columns == 3) {
    names = {"nx", "ny", "nz"};
  }
  names.resize(std::min(names.size(), columns));
  return names;
}

/// Where a number of a row is among the items.
std::size_t number_place(const NumpyTable& table, const NumpyColumn& column, std::uint64_t row,
                         std::size_t k) {
  std::uint64_t item = row, within = 0;
  if (table.structured()) {
    within = column.offset + k * column.size;
  } else {
    item = table.header.by_columns ? k * table.rows + row : row * table.columns + k;
  }
  return static_cast<std::size_t>(item * table.header.item_size + within);
}

/// Copies a number into the order of bytes of this machine.
void copy_number(const NumpyColumn& column, const std::uint8_t* from, std::uint8_t* to) {
  std::array<std::uint8_t, 8> number{};
  std::memcpy(number.data(), from, column.size);
  const auto end = number.begin() + static_cast<std::ptrdiff_t>(column.size);
  if (column.swapped) std::reverse(number.begin(), end);
  if (column.size < size_of(column.type)) {
    const float value = glm::unpackHalf1x16(load_number<std::uint16_t>(number.data()));
    std::memcpy(to, &value, sizeof(value));
  } else {
    std::memcpy(to, number.data(), column.size);
  }
}

/// Copies numbers of the tables behind each other, in the order of bytes of this machine.
class NumpyCollector {
 public:
  explicit NumpyCollector(std::uint64_t rows) : rows_(rows) {}

  /// The first `names.size()` numbers of a column of the table, whose items are in `items`.
  void add(const NumpyTable& table, const NumpyColumn& column, ByteView items,
           const std::vector<std::string>& names) {
    const std::size_t size = size_of(column.type), count = names.size();
    const std::size_t begin = (bytes_.size() + 7) / 8 * 8;
    bytes_.resize(begin + static_cast<std::size_t>(rows_) * count * size);
    std::uint8_t* to = bytes_.data() + begin;
    for (std::uint64_t row = 0; row < rows_; ++row) {
      for (std::size_t k = 0; k < count; ++k, to += size)
        copy_number(column, items.data() + number_place(table, column, row, k), to);
    }
    for (std::size_t k = 0; k < count; ++k)
      fields_.push_back({names[k], {begin + k * size, count * size, column.type}});
  }

  const std::uint8_t* data() const { return bytes_.data(); }
  const std::vector<NamedField>& fields() const { return fields_; }

 private:
  const std::uint64_t rows_;
  Bytes bytes_;
  std::vector<NamedField> fields_;
};

/// The items of a table, which are all there. `memory`: what the tables of a frame may still take,
/// in bytes, which becomes less.
Result<Bytes> items_of_table(const NumpyArrays& arrays, const NumpyTable& table,
                             std::uint64_t& memory) {
  const std::uint64_t row = std::uint64_t{table.columns} * table.header.item_size;
  const std::uint64_t all = table.rows * row;  // no overflow: rows are below max_points
  if (all > memory) {
    return fail(ErrorCode::limit, concat(table.text(), " takes ", all, " bytes, more than the ",
                                         memory, " that the frame may still take"));
  }
  memory -= all;
  Bytes bytes = TRY(arrays.begin(table.index, table.header.begin + all));
  if (bytes.size() < table.header.begin + all) {
    return fail(concat(table.text(), " ends after ", bytes.size() - table.header.begin, " of ", all,
                       " bytes"));
  }
  bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(table.header.begin));
  return bytes;
}

double position_number(const NumpyTable& table, ByteView items, std::uint64_t row, std::size_t k) {
  const NumpyColumn& column = table.header.columns.front();
  std::array<std::uint8_t, 8> number{};
  copy_number(column, items.data() + number_place(table, column, row, k), number.data());
  return with_number_type(column.type, [&](auto t) {
    return static_cast<double>(load_number<decltype(t)>(number.data()));
  });
}

void show_rows(const NumpyTable& table, ByteView items, ColumnGuess& guess) {
  const std::uint64_t step = std::max<std::uint64_t>(1, table.rows / kLookedRows);
  std::vector<double> row(std::min(table.columns, ColumnGuess::kMost));
  for (std::uint64_t i = 0; i < table.rows; i += step) {
    for (std::size_t k = 0; k < row.size(); ++k) row[k] = position_number(table, items, i, k);
    guess.see(row.data(), row.size());
  }
}

/// The names of the columns of the positions.
Result<std::vector<std::string>> position_names(const NumpyTable& table, ByteView items,
                                                const Reading& reading) {
  if (!reading.columns.empty()) {
    if (reading.columns.size() == table.columns) return reading.columns;
    return fail(concat(table.text(), " is to be read as ", reading.columns.size(),
                       " columns; --columns names them for all files"));
  }
  ColumnGuess guess;
  if (table.columns > 3) show_rows(table, items, guess);
  return guess.text_names(table.columns, false);
}

}  // namespace

std::size_t look_at_numpy(const ByteSource& source, const DecodeLimits& limits,
                          ColumnGuess& guess) {
  Bytes room;
  const Result<ByteView> bytes = source.all(room);
  if (!bytes) return 0;
  const Result<NumpyContents> contents = look_into(*bytes);
  if (!contents) return 0;
  const NumpyTable& table = contents->tables[contents->positions];
  if (!table.may_be_positions() || table.rows > limits.max_points) return 0;
  if (table.columns == 3) return 3;
  std::uint64_t memory = limits.max_memory;
  const Result<Bytes> items = items_of_table(contents->arrays, table, memory);
  if (!items) return 0;
  show_rows(table, *items, guess);
  return table.columns;
}

Result<PointCloud> read_numpy(const ByteSource& source, const DecodeLimits& limits,
                              const Reading& reading, ReadNotes& notes) {
  Bytes room;
  const NumpyContents contents = TRY(look_into(TRY(source.all(room))));
  const NumpyTable& positions = contents.tables[contents.positions];
  if (positions.rows > limits.max_points) {
    return fail(ErrorCode::limit, concat(positions.text(), " has more than ", limits.max_points,
                                         " points, the most that a frame may have"));
  }
  if (contents.arrays.is_archive() && positions.rows > limits.max_memory / kPointMemory) {
    return fail(ErrorCode::limit,
                concat(positions.text(), " has more points than the ", limits.max_memory >> 20,
                       " MiB that a frame may take allow; raise --frame-memory if you trust where "
                       "it comes from"));
  }
  notes.unread = contents.other_names;
  std::uint64_t memory = limits.max_memory;
  NumpyCollector collector(positions.rows);
  for (const NumpyTable& table : contents.tables) {
    if (table.rows != positions.rows) {
      notes.unread.push_back(table.text());
      continue;
    }
    const bool has_positions = &table == &positions && table.may_be_positions();
    Bytes items;
    for (const NumpyColumn& column : table.header.columns) {
      const std::string& name = table.structured() ? column.name : table.name;
      const std::size_t count = table.structured() ? column.count : table.columns;
      std::vector<std::string> names = row_names(
          name, count, has_positions || (&table == &positions && is_called(name, kPositionArrays)));
      if (!column.readable && name.empty()) continue;  // padding of an aligned structure
      if (!column.readable || names.empty()) {
        notes.unread.push_back(printable_name(name));
        continue;
      }
      if (items.empty()) items = TRY(items_of_table(contents.arrays, table, memory));
      if (has_positions) names = TRY(position_names(table, items, reading));
      collector.add(table, column, items, names);
    }
  }
  const RecordLayout layout = TRY(layout_of(collector.fields(), notes.unread));
  const auto rows = static_cast<std::size_t>(positions.rows);
  RecordCollector records(layout, rows);
  records.add(collector.data(), 0, rows);
  return records.finish(notes);
}

}  // namespace pointreel
