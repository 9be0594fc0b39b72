#include "codec/formats/text_points.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "codec/formats/named_fields.h"
#include "codec/formats/words.h"
#include "common/base/concat.h"
#include "common/base/parse_number.h"
#include "common/base/try.h"
#include "common/cloud/ply_header.h"

namespace pointreel {
namespace {

/// More columns than any real file has. They bound the memory that a line takes.
constexpr std::size_t kMaxColumns = 256;
/// Columns that are kept without names: those that have a meaning.
constexpr std::size_t kMaxUnnamed = 10;

enum class Separator : std::uint8_t { blank, comma, semicolon };

Separator separator_of(std::string_view line) {
  if (line.find(';') != std::string_view::npos) return Separator::semicolon;
  return line.find(',') != std::string_view::npos ? Separator::comma : Separator::blank;
}

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
    if (!over_ && trimmed(rest_).empty()) over_ = true;
    return true;
  }

 private:
  std::string_view rest_;
  const Separator separator_;
  bool over_;
};

std::vector<std::string_view> cells_of(std::string_view line, Separator separator) {
  std::vector<std::string_view> words;
  Cells cells(line, separator);
  for (std::string_view word; words.size() < kMaxColumns && cells.next(word);)
    words.push_back(word);
  return words;
}

bool parse_cell(std::string_view word, Separator separator, double& value) {
  if (parse_number(word, value)) return true;
  if (separator != Separator::semicolon || word.size() > 64) return false;
  std::string decimal(word);
  std::replace(decimal.begin(), decimal.end(), ',', '.');
  return parse_number(decimal, value);
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

/// What stands before the first point.
struct Head {
  std::vector<std::string> names;  ///< of the columns; empty if they have none
  Separator separator = Separator::blank;
  std::size_t columns = 0;
};

/// Whether words are names of columns: they have x, y and z among them.
bool are_names(const std::vector<std::string_view>& words) {
  const auto has = [&](char letter) {
    return std::any_of(words.begin(), words.end(), [&](std::string_view word) {
      return word.size() == 1 && (word[0] | 32) == letter;
    });
  };
  return has('x') && has('y') && has('z');
}

std::vector<std::string> to_strings(const std::vector<std::string_view>& words) {
  std::vector<std::string> names;
  for (const std::string_view word : words) names.emplace_back(word);
  return names;
}

/// Reads up to the first point, whose line is left in `lines`.
Result<Head> read_head(Lines& lines) {
  Head head;
  std::string_view line;
  for (Lines ahead = lines; ahead.next(line); lines = ahead) {
    if (trimmed(line).empty()) continue;
    if (const auto comment = comment_of(line)) {
      const auto words = cells_of(*comment, separator_of(*comment));
      if (are_names(words)) head.names = to_strings(words);
      continue;
    }
    head.separator = separator_of(line);
    const auto words = cells_of(line, head.separator);
    double value = 0.0;
    if (!words.empty() && parse_cell(words[0], head.separator, value)) {
      if (words.size() == 1) continue;  // the count of a .pts file
      head.columns = words.size();
      if (!head.names.empty() && head.names.size() < head.columns) head.names.clear();
      return head;
    }
    if (!head.names.empty() && words.size() >= head.names.size()) {
      head.columns = words.size();  // the first column has words that nobody reads
      return head;
    }
    if (!are_names(words)) {
      return fail(concat("line ", ahead.number(), ": '", printable(trimmed(line)),
                         "' is neither a point nor names of columns with x, y and z among them"));
    }
    head.names = to_strings(words);
  }
  return head;
}

/// What the numbers of columns without names look like.
struct Look {
  bool bytes = true;  ///< whole numbers from 0 to 255
  bool negative = false;
};

/// Names for columns without any.
class Guess {
 public:
  void see(const double* row, std::size_t columns) {
    for (std::size_t i = 3; i < std::min<std::size_t>(columns, kMaxUnnamed); ++i) {
      looks_[i].bytes &= row[i] >= 0.0 && row[i] <= 255.0 && row[i] == std::floor(row[i]);
      looks_[i].negative |= row[i] < 0.0;
    }
    if (columns < 6) return;
    const double length = row[3] * row[3] + row[4] * row[4] + row[5] * row[5];
    unit_ += std::abs(length - 1.0) < 0.01;
    ++rows_;
  }

  std::vector<std::string> names(std::size_t columns) const {
    std::vector<std::string> names{"x", "y", "z"};
    const auto add = [&names](std::initializer_list<const char*> more) {
      names.insert(names.end(), more.begin(), more.end());
    };
    const auto bytes = [this](std::size_t at) {
      return looks_[at].bytes && looks_[at + 1].bytes && looks_[at + 2].bytes;
    };
    const bool negative = looks_[3].negative || looks_[4].negative || looks_[5].negative;
    if (columns == 4) add({"intensity"});
    if (columns == 6 && (negative || unit_ * 10 > rows_ * 9)) {
      add({"nx", "ny", "nz"});
    } else if (columns == 7 && bytes(4) && !bytes(3)) {
      add({"intensity", "r", "g", "b"});
    } else if (columns == 6 || columns == 7 || columns == 9 || columns == 10) {
      add({"r", "g", "b"});
    }
    if (columns >= 9 && columns <= 10) add({"nx", "ny", "nz"});
    if (columns == 10 || (columns == 7 && names.size() == 6)) add({"intensity"});
    for (std::size_t i = names.size(); i < columns; ++i) names.push_back(concat("column ", i + 1));
    return names;
  }

 private:
  std::array<Look, kMaxUnnamed> looks_{};
  std::size_t unit_ = 0, rows_ = 0;
};

}  // namespace

Result<PointCloud> read_text_points(const ByteSource& source, std::vector<std::string>& unread) {
  Bytes room;
  std::string_view text = text_of(TRY(source.all(room)));
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  Lines lines(text);
  const Head head = TRY(read_head(lines));
  if (head.columns == 0) return fail("has no points");
  if (head.columns < 3) {
    return fail(concat("line ", lines.number() + 1, ": has ", head.columns,
                       " numbers, but a point has at least 3"));
  }

  // Columns that nobody reads are not kept.
  std::vector<NamedField> named;
  for (const std::string& name : head.names) named.push_back({name, {}});
  std::vector<bool> keep(head.columns, true), must_be_number(head.columns, false);
  if (!named.empty()) {
    // Each field gets the number of its column as its offset, to see which are read.
    for (std::size_t i = 0; i < named.size(); ++i) named[i].field = {i, 0, NumberType::float64};
    const RecordLayout layout = TRY(layout_of(named, unread));
    // What is not read: the columns that are in no part of the layout.
    std::fill(keep.begin(), keep.end(), false);
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
  } else {
    std::fill(must_be_number.begin(), must_be_number.begin() + 3, true);
    std::fill(keep.begin() + std::min<std::ptrdiff_t>(kMaxUnnamed, std::ssize(keep)), keep.end(),
              false);
  }
  std::vector<std::size_t> kept;  // columns
  for (std::size_t i = 0; i < head.columns; ++i)
    if (keep[i]) kept.push_back(i);

  std::vector<double> values;  // of the kept columns, row by row
  Guess guess;
  std::size_t rows = 0;
  for (std::string_view line; lines.next(line);) {
    if (trimmed(line).empty() || comment_of(line)) continue;
    Cells cells(line, head.separator);
    std::size_t column = 0, next = 0;
    for (std::string_view word; next < kept.size() && cells.next(word); ++column) {
      if (column != kept[next]) continue;
      double value = 0.0;
      if (!parse_cell(word, head.separator, value)) {
        value = std::numeric_limits<double>::quiet_NaN();
        if (!must_be_number[column]) {
          values.push_back(value);
          ++next;
          continue;
        }
        return fail(concat("line ", lines.number(), ": '", printable(word), "' in column ",
                           column + 1, " is not a number"));
      }
      values.push_back(value);
      ++next;
    }
    if (next < kept.size()) {
      return fail(concat("line ", lines.number(), ": has ", column,
                         " columns, but the first point ", "has ", head.columns));
    }
    guess.see(values.data() + rows * kept.size(), kept.size());
    ++rows;
  }

  if (named.empty()) {
    for (const std::string& name : guess.names(head.columns)) named.push_back({name, {}});
  }
  // The values are records of doubles, without the columns that were left out.
  std::vector<NamedField> fields;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    fields.push_back({named[kept[i]].name,
                      {i * sizeof(double), kept.size() * sizeof(double), NumberType::float64}});
  }
  std::vector<std::string> told;  // those of a header were told above
  const RecordLayout layout = TRY(layout_of(fields, told));
  if (head.names.empty()) {
    unread.insert(unread.end(), told.begin(), told.end());
    for (std::size_t i = kept.size(); i < head.columns; ++i)
      unread.push_back(concat("column ", i + 1));
  }
  RecordCollector collector(layout, rows);
  collector.add(reinterpret_cast<const std::uint8_t*>(values.data()), 0, rows);
  return collector.finish();
}

}  // namespace pointreel
