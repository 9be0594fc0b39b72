#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "pointreel/error.h"

/// Reads JSON without building a tree of it: a value is a view of its text. Memory is therefore
/// taken only for what a caller keeps, and members that nobody knows cost nothing.
///
/// Trust: the texts may be hostile. parse_json checks the whole text before any value of it is
/// read. It refuses what is nested deeper than 16, and an object with the same key twice. Its time
/// grows as n log n with the length of the text. It takes 8 bytes for each key of the objects that
/// are open, and as much as the longest string.
namespace pointreel {

/// A value in a text that parse_json has accepted and that must outlive it.
class JsonValue {
 public:
  /// The value at the beginning of `text`, which may go on after it.
  explicit JsonValue(std::string_view text);

  bool is_null() const { return text_.front() == 'n'; }
  bool is_object() const { return text_.front() == '{'; }
  bool is_array() const { return text_.front() == '['; }
  bool is_string() const { return text_.front() == '"'; }

  /// A number from 0 to 2^64 - 1 that is written without a fraction or an exponent.
  std::optional<std::uint64_t> integer() const;
  std::optional<double> number() const;
  std::optional<bool> boolean() const;
  std::optional<std::string> string() const;
  /// The number of elements or members, for which the text of an array or object is read once.
  std::size_t size() const;

  /// The text from the first character to the last, without spaces around it.
  std::string_view text() const { return text_; }

 private:
  std::string_view text_;
};

/// Walks over the elements of an array or the members of an object, and over nothing if the value
/// is neither:
///
///   for (JsonItems item(array); item.next();) use(item.value());
class JsonItems {
 public:
  explicit JsonItems(const JsonValue& of);

  /// Goes on to the next item. False after the last one.
  bool next();
  const JsonValue& value() const { return value_; }
  /// The key, a string. Only for members of an object.
  const JsonValue& key() const { return key_; }

 private:
  std::string_view rest_;  ///< begins at the next item
  bool members_;
  JsonValue key_, value_;
};

/// True if the value is the string `text`. Takes time in proportion to `text`.
bool is_text(const JsonValue& value, std::string_view text);

/// The value of a whole text, which may have spaces around it.
Result<JsonValue> parse_json(std::string_view text);

}  // namespace pointreel
