#include "codec/files/numpy_header.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include "codec/files/words.h"
#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr std::size_t kMostColumns = 256, kMostItem = std::size_t{1} << 20, kMostDimensions = 32;

/// Walks over a literal of Python.
class Literal {
 public:
  explicit Literal(std::string_view text) : rest_(text) {}

  bool accept(char c) {
    skip_blanks();
    if (!rest_.starts_with(c)) return false;
    rest_.remove_prefix(1);
    return true;
  }

  /// A text in quotes without escapes.
  std::optional<std::string_view> text() {
    skip_blanks();
    if (rest_.empty() || (rest_[0] != '\'' && rest_[0] != '"')) return std::nullopt;
    const std::size_t end = rest_.find(rest_[0], 1);
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view inside = rest_.substr(1, end - 1);
    rest_.remove_prefix(end + 1);
    return inside;
  }

  std::optional<std::uint64_t> number() {
    skip_blanks();
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    if (error != std::errc()) return std::nullopt;
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    accept('L');  // as Python 2 writes long ones
    return value;
  }

  /// "(3, 4)", "(3,)", "()"
  std::optional<std::vector<std::uint64_t>> tuple() {
    if (!accept('(')) return std::nullopt;
    std::vector<std::uint64_t> numbers;
    while (!accept(')')) {
      const auto one = number();
      if (!one || numbers.size() == kMostDimensions) return std::nullopt;
      numbers.push_back(*one);
      if (!accept(',') && !rest_.starts_with(')')) return std::nullopt;
    }
    return numbers;
  }

  bool accept_word(std::string_view word) {
    skip_blanks();
    if (!rest_.starts_with(word)) return false;
    rest_.remove_prefix(word.size());
    return true;
  }

 private:
  void skip_blanks() {
    while (!rest_.empty() && is_blank(rest_.front())) rest_.remove_prefix(1);
  }

  std::string_view rest_;
};

std::optional<NumberType> number_type(char kind, std::size_t size) {
  for (const NumberType type :
       {NumberType::int8, NumberType::int16, NumberType::int32, NumberType::int64}) {
    if (size_of(type) != size) continue;
    if (kind == 'i') return type;
    // Each unsigned type follows the signed one.
    if (kind == 'u' || (kind == 'b' && size == 1))
      return static_cast<NumberType>(static_cast<std::uint8_t>(type) + 1);
  }
  if (kind == 'f' && size == 8) return NumberType::float64;
  if (kind == 'f' && (size == 4 || size == 2)) return NumberType::float32;
  return std::nullopt;
}

/// A type such as "<f4", without its name and place.
std::optional<NumpyColumn> column_of(std::string_view descr) {
  NumpyColumn column;
  if (!descr.empty() && std::string_view("<>|=").find(descr[0]) != std::string_view::npos) {
    column.swapped = descr[0] == '>';
    descr.remove_prefix(1);
  }
  if (descr.empty()) return std::nullopt;
  const char kind = descr[0];
  std::size_t size = kind == 'O' ? 8 : 0;
  std::from_chars(descr.data() + 1, descr.data() + descr.size(), size);
  if (kind == 'U' && size <= kMostItem) size *= 4;
  if (size > kMostItem) return std::nullopt;
  const auto type = number_type(kind, size);
  column.readable = type.has_value();
  column.object = kind == 'O';
  column.type = type.value_or(NumberType::uint8);
  column.size = size;
  return column;
}

bool add_column(NumpyColumn column, NumpyHeader& header) {
  column.offset = header.item_size;
  if (column.count > kMostItem) return false;
  header.item_size += column.count * column.size;
  header.columns.push_back(std::move(column));
  return header.item_size <= kMostItem && header.columns.size() <= kMostColumns;
}

/// "('x', '<f4')", "('xyz', '<f4', (3,))"; the name may be a pair of a title and a name.
bool read_field(Literal& literal, NumpyHeader& header) {
  if (!literal.accept('(')) return false;
  const bool titled = literal.accept('(');
  auto name = literal.text();
  if (titled && name) {
    if (!literal.accept(',')) return false;
    name = literal.text();
    if (!literal.accept(')')) return false;
  }
  if (!name || !literal.accept(',')) return false;
  const auto descr = literal.text();  // none where structures are nested
  auto column = descr ? column_of(*descr) : std::nullopt;
  if (!column) return false;
  column->name = *name;
  if (literal.accept(',')) {
    const auto shape = literal.tuple();
    if (!shape) return false;
    for (const std::uint64_t length : *shape) {
      if (length > kMostItem || column->count > kMostItem) return false;
      column->count *= length;
    }
  }
  return literal.accept(')') && add_column(std::move(*column), header);
}

bool read_descr(Literal& literal, NumpyHeader& header) {
  if (const auto descr = literal.text()) {
    auto column = column_of(*descr);
    return column && add_column(std::move(*column), header);
  }
  if (!literal.accept('[')) return false;
  while (!literal.accept(']')) {
    if (!read_field(literal, header)) return false;
    literal.accept(',');
  }
  return true;
}

bool read_dictionary(Literal literal, NumpyHeader& header) {
  bool has_shape = false;
  if (!literal.accept('{')) return false;
  while (!literal.accept('}')) {
    const auto key = literal.text();
    if (!key || !literal.accept(':')) return false;
    if (*key == "descr" && header.columns.empty()) {
      if (!read_descr(literal, header)) return false;
    } else if (*key == "fortran_order") {
      header.by_columns = literal.accept_word("True");
      if (!header.by_columns && !literal.accept_word("False")) return false;
    } else if (*key == "shape") {
      auto shape = literal.tuple();
      if (!shape) return false;
      header.shape = std::move(*shape);
      has_shape = true;
    } else {
      return false;
    }
    literal.accept(',');
  }
  return has_shape && !header.columns.empty() && header.item_size > 0;
}

}  // namespace

bool NumpyHeader::is_pickled() const {
  return std::any_of(columns.begin(), columns.end(),
                     [](const NumpyColumn& column) { return column.object; });
}

std::string NumpyHeader::shape_text() const {
  std::string text = "(";
  for (std::size_t i = 0; i < shape.size(); ++i)
    text += concat(i == 0 ? "" : ", ", std::to_string(shape[i]));
  return text + (shape.size() == 1 ? ",)" : ")");
}

Result<NumpyHeader> read_numpy_header(ByteView bytes) {
  const std::string_view text = text_of(bytes);
  constexpr std::size_t kOld = 10, kNew = 12;
  if (!text.starts_with(kMagic) || bytes.size() < kNew) return fail("is not an array of numpy");
  const bool old = bytes[6] == 1;
  if (bytes[6] < 1 || bytes[6] > 3)
    return fail(concat("has version ", bytes[6], " of numpy's format, which is unknown"));
  const std::size_t length = old ? load_number<std::uint16_t>(&bytes[8])
                                 : std::size_t{load_number<std::uint32_t>(&bytes[8])};
  const std::size_t at = old ? kOld : kNew;
  if (length > kNumpyHeader - kNew)
    return fail(concat("has a header of ", length, " bytes, which is too long"));
  if (at + length > bytes.size()) return fail("ends in its header");
  NumpyHeader header;
  header.begin = at + length;
  if (!read_dictionary(Literal(text.substr(at, length)), header))
    return fail("has a header that cannot be read");
  return header;
}

}  // namespace pointreel
