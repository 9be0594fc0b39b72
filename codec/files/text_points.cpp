#include "codec/files/text_points.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "codec/files/attribute_names.h"
#include "codec/files/column_guess.h"
#include "codec/files/named_fields.h"
#include "codec/files/ply_header.h"
#include "codec/files/sample.h"
#include "codec/files/words.h"
#include "common/base/concat.h"
#include "common/base/letter_case.h"
#include "common/base/parse_number.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// More columns than any real file has. They bound the memory that a line takes.
constexpr std::size_t kMaxColumns = 256;
enum class Separator : std::uint8_t { blank, comma, semicolon };

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

/// Words of a line. Between commas and semicolons they may be empty, and in quotes.
class Cells {
 public:
  Cells(std::string_view line, Separator separator) : rest_(line), separator_(separator) {
    if (separator == Separator::blank) rest_ = trimmed(rest_);
    over_ = rest_.empty();
  }

  bool next(std::string_view& word) {
    if (over_) return false;
    if (separator_ == Separator::blank) {
      word = take_word(rest_);
      over_ = rest_.empty();
      return true;
    }
    const std::size_t end = rest_.find(separator_ == Separator::comma ? ',' : ';');
    word = trimmed(rest_.substr(0, end));
    if (word.size() >= 2 && word.front() == '"' && word.back() == '"')
      word = word.substr(1, word.size() - 2);
    over_ = end == std::string_view::npos;
    if (!over_) rest_.remove_prefix(end + 1);
    // A separator at the end of the line is no empty word.
    if (!over_ && trimmed(rest_).empty()) over_ = ends_with_separator_ = true;
    return true;
  }

  /// After the last word: an empty one may have been meant to follow, as tables have it.
  bool ends_with_separator() const { return ends_with_separator_; }

 private:
  std::string_view rest_;
  const Separator separator_;
  bool over_;
  bool ends_with_separator_ = false;
};

/// `names`: how many columns have names. The last word of as many may be empty.
std::vector<std::string_view> cells_of(std::string_view line, Separator separator,
                                       std::size_t names = 0) {
  std::vector<std::string_view> words;
  Cells cells(line, separator);
  for (std::string_view word; words.size() < kMaxColumns && cells.next(word);)
    words.push_back(word);
  if (words.size() + 1 == names && cells.ends_with_separator()) words.emplace_back();
  return words;
}

/// Where commas do not separate, one may be the decimal point. Older programs of Windows write what
/// is no number, or infinite, as 1.#QNAN, -1.#IND and 1.#INF.
bool parse_cell(std::string_view word, Separator separator, double& value) {
  if (parse_number(word, value)) return true;
  const std::string_view unsigned_word = word.substr(word.starts_with('-') ? 1 : 0);
  if (unsigned_word.starts_with("1.#") || unsigned_word.starts_with("1,#")) {
    value = std::numeric_limits<double>::quiet_NaN();
    return true;
  }
  if (separator == Separator::comma || word.size() > 64) return false;
  std::string decimal(word);
  std::replace(decimal.begin(), decimal.end(), ',', '.');
  return parse_number(decimal, value);
}

/// Whether words between blanks are numbers, and commas in them decimal points: no comma stands
/// beside a blank.
bool has_decimal_commas(std::string_view line) {
  std::size_t words = 0;
  for (std::string_view word = take_word(line); !word.empty(); word = take_word(line), ++words) {
    double value = 0.0;
    if (word.front() == ',' || word.back() == ',' || !parse_cell(word, Separator::blank, value))
      return false;
  }
  return words >= 3;
}

Separator separator_of(std::string_view line) {
  if (line.find(';') != std::string_view::npos) return Separator::semicolon;
  if (line.find(',') == std::string_view::npos) return Separator::blank;
  return has_decimal_commas(line) ? Separator::blank : Separator::comma;
}

/// The line without the marks that make it a comment; nothing if it is none.
std::optional<std::string_view> comment_of(std::string_view line) {
  const std::string_view text = trimmed(line);
  for (const std::string_view mark : {"#", "//", "%"}) {
    if (!text.starts_with(mark)) continue;
    return trimmed(text.substr(std::min(text.find_first_not_of("#/% "), text.size())));
  }
  return std::nullopt;
}

/// What tables have in place of a number that is not known.
bool is_missing(std::string_view cell) {
  constexpr std::array<std::string_view, 5> kMissing{"", "na", "n/a", "null", "none"};
  return std::any_of(kMissing.begin(), kMissing.end(),
                     [&](std::string_view word) { return equal_in_any_case(cell, word); });
}

/// Also where tables have rows of empty cells.
bool is_empty_row(std::string_view line) {
  return line.find_first_not_of(" \t\r,;") == std::string_view::npos;
}

/// Spreadsheets begin with a line as "sep=;".
bool names_separator(std::string_view line) {
  line = trimmed(line);
  return line.size() == 5 && in_small_letters(line).starts_with("sep=");
}

/// What stands before the first point.
struct Head {
  std::vector<std::string> names;  ///< of the columns; empty if they have none
  std::size_t surplus = 0;         ///< names that were left out, since there are fewer columns
  Separator separator = Separator::blank;
  std::size_t columns = 0;             ///< of the first point; 0 without points
  std::optional<std::uint64_t> count;  ///< what the first line says, as in .pts files
};

/// Whether they have those of a position among them.
bool are_names(const std::vector<std::string>& names) {
  const auto has = [&](std::string_view wanted) {
    return std::any_of(names.begin(), names.end(),
                       [&](const std::string& name) { return equal_in_any_case(name, wanted); });
  };
  return std::any_of(kPositionNames.begin(), kPositionNames.end(),
                     [&](const VectorNames& spelling) {
                       return std::all_of(spelling.begin(), spelling.end(), has);
                     });
}

/// What ParaView calls Points:0 or Points_0, and VeloView Points_m_XYZ:0, is x, and so on.
struct NumberedNames {
  std::string_view array;  ///< in small letters
  VectorNames names;
};
constexpr std::array<NumberedNames, 5> kNumberedNames{{{"points", {"x", "y", "z"}},
                                                       {"points_m_xyz", {"x", "y", "z"}},
                                                       {"normals", {"nx", "ny", "nz"}},
                                                       {"rgb", {"red", "green", "blue"}},
                                                       {"colors", {"red", "green", "blue"}}}};

/// A column's name without quotes, and without a unit as in "X [mm]" and "x(m)".
std::string column_name(std::string_view word) {
  if (word.size() >= 2 && word.front() == '"' && word.back() == '"')
    word = word.substr(1, word.size() - 2);
  const std::size_t unit = word.find_first_of("[(");
  if (unit != 0 && unit != std::string_view::npos && (word.back() == ']' || word.back() == ')'))
    word = trimmed(word.substr(0, unit));
  if (word.size() < 2) return std::string(word);
  const char mark = word[word.size() - 2];
  const std::size_t number = static_cast<std::size_t>(word.back() - '0');
  for (const auto& [array, names] : kNumberedNames) {
    if ((mark == ':' || mark == '_') && number < names.size() &&
        equal_in_any_case(word.substr(0, word.size() - 2), array))
      return std::string(names[number]);
  }
  return std::string(word);
}

/// Names for the first columns. COLMAP's points end in lists of any length, which have none.
struct HeaderNames {
  std::vector<std::string> names;
  bool lists_follow = false;
};

HeaderNames names_of(const std::vector<std::string_view>& words) {
  HeaderNames header;
  for (const std::string_view word : words) {
    header.lists_follow = word.starts_with("TRACK[]");
    if (header.lists_follow) break;
    header.names.push_back(column_name(word));
  }
  return header;
}

std::uint64_t to_count(double value) {
  return value >= 0.0 && value < 1e15 ? static_cast<std::uint64_t>(value) : 0;
}

/// Reads up to the first point, whose line is left in `lines`. `named`: how many columns the user
/// has named, so that a first line of as many words may be anything; or 0.
Result<Head> read_head(Lines& lines, std::size_t named = 0) {
  Head head;
  bool lists_follow = false;
  std::string_view line;
  for (Lines ahead = lines; ahead.next(line); lines = ahead) {
    if (is_empty_row(line) || names_separator(line)) continue;
    if (const auto comment = comment_of(line)) {
      HeaderNames header = names_of(cells_of(*comment, separator_of(*comment)));
      if (!are_names(header.names)) continue;
      head.names = std::move(header.names);
      lists_follow = header.lists_follow;
      continue;
    }
    head.separator = separator_of(line);
    const auto words = cells_of(line, head.separator, head.names.size());
    double value = 0.0;
    if (!words.empty() && parse_cell(words[0], head.separator, value)) {
      if (words.size() == 1) {
        head.count = head.count.value_or(0) + to_count(value);
        continue;
      }
      head.columns = words.size();
      if (lists_follow && head.names.size() < head.columns) {
        head.names.resize(head.columns, "_");
      } else if (head.names.size() < head.columns) {
        head.names.clear();
      } else {
        head.surplus = head.names.size() - head.columns;
        head.names.resize(head.columns);
      }
      return head;
    }
    if (!head.names.empty() && words.size() >= head.names.size()) {
      head.columns = words.size();  // the first column has words that nobody reads
      return head;
    }
    head.names = names_of(words).names;
    if (!are_names(head.names) && head.names.size() != named) {
      return fail(concat("line ", ahead.number(), ": '", printable(trimmed(line)),
                         "' is neither a point nor names of columns with x, y and z among them; "
                         "--columns names them"));
    }
  }
  return head;
}

/// Also without the Ctrl-Z with which programs of DOS end text.
std::string_view without_marks(std::string_view text) {
  text = without_utf8_mark(text);
  if (text.ends_with('\x1a')) text.remove_suffix(1);
  return text;
}

/// Looks at the points of a text that have as many columns as its first.
void look(const Head& head, Lines lines, ColumnGuess& guess) {
  std::vector<double> row(std::min(head.columns, ColumnGuess::kMost));
  guess.begin();
  for (std::string_view line; lines.next(line);) {
    if (comment_of(line)) continue;
    Cells cells(line, head.separator);
    std::size_t column = 0;
    std::string_view word;
    for (; column < row.size() && cells.next(word); ++column) {
      if (!parse_cell(word, head.separator, row[column]))
        row[column] = std::numeric_limits<double>::quiet_NaN();
    }
    if (column == row.size()) guess.see(row.data(), row.size());
  }
}

/// The columns of a file: which of them are kept, and what they are.
struct Columns {
  std::vector<std::size_t> kept;
  std::vector<NamedField> fields;     ///< of the kept ones, as records of doubles
  std::vector<bool> must_be_numbers;  ///< of the kept ones
};

/// Columns that nobody reads are not kept.
Result<Columns> columns_of(std::size_t count, const std::vector<std::string>& names,
                           std::vector<std::string>& unread) {
  // Each field gets the number of its column as its offset, to see which are read.
  std::vector<NamedField> named;
  for (std::size_t i = 0; i < names.size(); ++i)
    named.push_back({names[i], {i, 0, NumberType::float64}});
  const RecordLayout layout = TRY(layout_of(named, unread));
  std::vector<bool> keep(count, false), must_be_number(count, false);
  const auto use = [&](const RecordField& field, bool number) {
    if (field.offset >= keep.size()) return;
    keep[field.offset] = true;
    must_be_number[field.offset] = number;
  };
  for (const RecordField& field : layout.position) use(field, true);
  for (const auto* vector : {&layout.normal, &layout.color}) {
    if (!*vector) continue;
    for (const RecordField& field : **vector) use(field, true);
  }
  for (const RecordScalar& scalar : layout.scalars) use(scalar.field, false);
  Columns columns;
  for (std::size_t i = 0; i < count; ++i) {
    if (!keep[i]) continue;
    columns.kept.push_back(i);
    columns.must_be_numbers.push_back(must_be_number[i]);
  }
  const std::size_t size = columns.kept.size() * sizeof(double);
  for (std::size_t i = 0; i < columns.kept.size(); ++i)
    columns.fields.push_back(
        {names[columns.kept[i]], {i * sizeof(double), size, NumberType::float64}});
  return columns;
}

std::string join(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " ") + printable(name);
  return text;
}

}  // namespace

std::vector<std::string> guess_text_columns(std::span<const ByteView> samples, bool pts,
                                            bool& counts) {
  counts = false;
  struct Unnamed {
    Head head;
    Lines lines;
  };
  std::vector<Unnamed> unnamed;
  std::map<std::size_t, std::size_t> files;  // by their number of columns
  std::vector<std::string> names;
  for (const ByteView sample : samples) {
    Lines lines(without_marks(text_of(sample)));
    Result<Head> head = read_head(lines);
    // Reading the file says what is wrong.
    if (!head || head->columns < 3) continue;
    if (!head->names.empty()) {
      if (names.empty()) names = std::move(head->names);
      continue;
    }
    ++files[head->columns];
    unnamed.push_back({std::move(*head), lines});
  }
  if (unnamed.empty()) return {};
  std::size_t columns = unnamed.front().head.columns;
  for (const auto& [number, count] : files)
    if (count > files[columns]) columns = number;
  ColumnGuess guess;
  for (const Unnamed& file : unnamed) {
    if (file.head.columns != columns) continue;
    pts |= file.head.count.has_value();
    look(file.head, file.lines, guess);
  }
  // Files that were divided have a header in the first alone.
  if (names.size() == columns) {
    // As --columns takes them.
    for (std::string& name : names)
      if (!is_scalar_name(name) || name.find(',') != std::string::npos) name = "_";
    return names;
  }
  counts = columns > 3 && guess.first_counts_rows();
  return guess.text_names(columns, pts);
}

Result<PointCloud> read_text_points(const ByteSource& source, const Reading& reading,
                                    ReadNotes& notes) {
  Bytes room;
  const ByteView bytes = TRY(source.all(room));
  const std::string_view text = text_of(bytes);
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
    return fail("is UTF-16 text; save it as UTF-8");
  Lines lines(without_marks(text));
  Head head = TRY(read_head(lines, reading.columns.size()));
  if (head.columns == 0 && (!head.names.empty() || head.count == 0)) return PointCloud();
  if (head.columns == 0) return fail("has no points");
  if (head.columns < 3) {
    return fail(concat("line ", lines.number() + 1, ": has ", head.columns,
                       " numbers, but a point has at least 3"));
  }
  std::vector<std::string> names = head.names;
  if (!reading.columns.empty()) {
    names = reading.columns;
    if (names.size() != head.columns) {
      return fail(concat("line ", lines.number() + 1, ": has ", head.columns,
                         " columns, but is to be read as ", join(names),
                         " as the others: name the files that are frames, or give all of them the "
                         "same --columns"));
    }
  } else if (names.empty()) {
    const auto sample = TRY(sample_of(source, CloudFormat::text));
    const ByteView view = sample ? ByteView(*sample) : bytes;
    bool counts = false;
    names = guess_text_columns({&view, 1}, false, counts);
    if (names.size() != head.columns) names = ColumnGuess().text_names(head.columns, false);
  }
  const Columns columns = TRY(columns_of(head.columns, names, notes.unread));
  const std::vector<std::size_t>& kept = columns.kept;

  std::vector<double> values;  // of the kept columns, row by row
  std::vector<bool> has_numbers(kept.size()), has_words(kept.size());
  std::size_t rows = 0, longer = 0;
  for (std::string_view line; lines.next(line);) {
    if (is_empty_row(line) || comment_of(line)) continue;
    Cells cells(line, head.separator);
    std::size_t column = 0, next = 0;
    for (std::string_view word; next < kept.size() && cells.next(word); ++column) {
      if (column != kept[next]) continue;
      double value = 0.0;
      if (!parse_cell(word, head.separator, value)) {
        if (columns.must_be_numbers[next] && !is_missing(word)) {
          return fail(concat("line ", lines.number(), ": '", printable(word), "' in column ",
                             column + 1, " is not a number"));
        }
        value = std::numeric_limits<double>::quiet_NaN();
        if (!is_missing(word)) has_words[next] = true;
      } else {
        has_numbers[next] = true;
      }
      values.push_back(value);
      ++next;
    }
    if (next + 1 == kept.size() && column == kept[next] && column + 1 == head.columns &&
        cells.ends_with_separator() && !columns.must_be_numbers[next]) {
      values.push_back(std::numeric_limits<double>::quiet_NaN());
      ++next;
    }
    if (next < kept.size()) {
      // Scans that follow each other in a .pts file begin with their counts.
      if (head.count && column == 1 && next == 1) {
        *head.count += to_count(values.back());
        values.pop_back();
        continue;
      }
      return fail(concat("line ", lines.number(), ": has ", column,
                         " columns, but the first point ", "has ", head.columns));
    }
    std::string_view more;
    longer += column == head.columns && cells.next(more) && !comment_of(more);
    ++rows;
  }
  if (longer > 0) {
    notes.warnings.push_back(concat("has ", longer, " lines with more columns than the first ",
                                    "point, which has ", head.columns, "; they are not read"));
  }
  if (head.surplus > 0 && reading.columns.empty()) {
    notes.warnings.push_back(concat("has names for ", head.columns + head.surplus,
                                    " columns, but its points have ", head.columns,
                                    "; --columns says what these are"));
  }
  if (head.count && *head.count != rows) {
    notes.warnings.push_back(
        concat("says that it has ", *head.count, " points, but there are ", rows));
  }
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (has_words[i] && !has_numbers[i])
      notes.unread.push_back(printable(names[kept[i]]) + " (words)");
  }
  // The values are records of doubles.
  std::vector<std::string> told;
  const RecordLayout layout = TRY(layout_of(columns.fields, told));
  RecordCollector collector(layout, rows);
  collector.add(reinterpret_cast<const std::uint8_t*>(values.data()), 0, rows);
  return collector.finish(notes);
}

}  // namespace pointreel
