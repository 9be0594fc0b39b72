#include "common/base/json_value.h"

#include <algorithm>
#include <charconv>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/base/parse_double.h"
#include "pointreel/bytes.h"

namespace pointreel {
namespace {

using nlohmann::json;

/// Far above the nesting of a manifest, which is six.
constexpr std::size_t kMaxNesting = 16;

/// Receives the tokens of a text.
class Tokens : public nlohmann::json_sax<json> {
 public:
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(json::number_integer_t) override { return true; }
  bool number_unsigned(json::number_unsigned_t) override { return true; }
  bool number_float(json::number_float_t, const json::string_t&) override { return true; }
  bool string(json::string_t&) override { return true; }
  bool binary(json::binary_t&) override { return true; }
  bool key(json::string_t&) override { return true; }
  bool start_array(std::size_t) override { return true; }
  bool end_array() override { return true; }
  bool start_object(std::size_t) override { return true; }
  bool end_object() override { return true; }
  bool parse_error(std::size_t, const std::string&, const json::exception&) override {
    return false;
  }
};

/// Goes on until `tokens` refuse one. Of the library's templates this is the only instance.
bool read_tokens(std::string_view text, Tokens& tokens) {
  return json::sax_parse(text.begin(), text.end(), &tokens);
}

/// Keeps the one string that the text is.
class StringKeeper : public Tokens {
 public:
  bool string(json::string_t& value) override {
    kept = std::move(value);
    return true;
  }
  std::string kept;
};

/// Keeps no tokens. Refuses the first fault.
class TokenGuard : public Tokens {
 public:
  bool start_array(std::size_t) override { return open(); }
  bool end_array() override { return close(); }
  bool start_object(std::size_t) override { return open(); }
  bool end_object() override { return close(); }
  bool parse_error(std::size_t, const std::string&, const json::exception&) override {
    return refuse("is not valid JSON");
  }

  /// Two keys with the same checksum are taken for the same key. That happens by intention alone,
  /// to which an error is the right answer.
  bool key(json::string_t& key) override {
    keys_.push_back(checksum_of({reinterpret_cast<const std::uint8_t*>(key.data()), key.size()}));
    return true;
  }

  const char* fault() const { return fault_; }

 private:
  bool open() {
    if (open_.size() == kMaxNesting) return refuse("is nested too deep");
    open_.push_back(keys_.size());
    return true;
  }

  bool close() {
    const auto begin = keys_.begin() + static_cast<std::ptrdiff_t>(open_.back());
    std::sort(begin, keys_.end());
    if (std::adjacent_find(begin, keys_.end()) != keys_.end()) {
      return refuse("has an object with the same key twice");
    }
    keys_.resize(open_.back());
    open_.pop_back();
    return true;
  }

  bool refuse(const char* fault) {
    fault_ = fault;
    return false;
  }

  std::vector<std::uint64_t> keys_;  ///< checksums of the keys of all open objects
  std::vector<std::size_t> open_;    ///< where in `keys_` each open object or array begins
  const char* fault_ = nullptr;
};

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

std::string_view skip_spaces(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  return text;
}

/// The length of the string at the beginning of the text, with its quotes.
std::size_t string_length(std::string_view text) {
  std::size_t end = 1;
  while (end < text.size() && text[end] != '"') end += text[end] == '\\' ? 2 : 1;
  return std::min(end + 1, text.size());
}

/// The length of the value at the beginning of the text.
std::size_t value_length(std::string_view text) {
  std::size_t at = 0, open = 0;
  while (at < text.size()) {
    switch (text[at]) {
      case '"':
        at += string_length(text.substr(at));
        if (open == 0) return at;
        continue;
      case '[':
      case '{':
        ++open;
        break;
      case ']':
      case '}':
        if (open == 0) return at;  // a number or a word ends here
        if (--open == 0) return at + 1;
        break;
      case ',':
      case ' ':
      case '\t':
      case '\n':
      case '\r':
        if (open == 0) return at;
        break;
      default:
        break;
    }
    ++at;
  }
  return at;
}

}  // namespace

JsonValue::JsonValue(std::string_view text) : text_(text.substr(0, value_length(text))) {}

std::optional<std::uint64_t> JsonValue::integer() const {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
  if (error != std::errc() || end != text_.data() + text_.size()) return std::nullopt;
  return value;
}

std::optional<double> JsonValue::number() const {
  double value = 0.0;
  const auto [end, error] = parse_double(text_.data(), text_.data() + text_.size(), value);
  // The only number out of range that parse_json accepts is one too close to zero.
  if (error == std::errc::result_out_of_range) return 0.0;
  if (error != std::errc() || end != text_.data() + text_.size()) return std::nullopt;
  return value;
}

std::optional<bool> JsonValue::boolean() const {
  if (text_ == "true") return true;
  if (text_ == "false") return false;
  return std::nullopt;
}

std::optional<std::string> JsonValue::string() const {
  if (!is_string()) return std::nullopt;
  const std::string_view inside = text_.substr(1, text_.size() - 2);
  if (inside.find('\\') == std::string_view::npos) return std::string(inside);
  StringKeeper keeper;
  read_tokens(text_, keeper);
  return std::move(keeper.kept);
}

std::size_t JsonValue::size() const {
  std::size_t count = 0;
  for (JsonItems item(*this); item.next();) ++count;
  return count;
}

JsonItems::JsonItems(const JsonValue& of) : members_(of.is_object()), key_("null"), value_("null") {
  if (of.is_array() || of.is_object()) rest_ = skip_spaces(of.text().substr(1));
}

bool JsonItems::next() {
  if (rest_.empty() || rest_.front() == ']' || rest_.front() == '}') return false;
  const auto skip = [this](std::size_t size) { rest_ = skip_spaces(rest_.substr(size)); };
  if (members_) {
    key_ = JsonValue(rest_);
    skip(key_.text().size());
    skip(1);  // the colon
  }
  value_ = JsonValue(rest_);
  skip(value_.text().size());
  if (!rest_.empty() && rest_.front() == ',') skip(1);
  return true;
}

bool is_text(const JsonValue& value, std::string_view text) {
  if (!value.is_string()) return false;
  const std::string_view inside = value.text().substr(1, value.text().size() - 2);
  if (inside == text) return true;
  // At most six characters stand for each byte: \u0041.
  return inside.size() <= 6 * text.size() && inside.find('\\') != std::string_view::npos &&
         value.string() == text;
}

Result<JsonValue> parse_json(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  // To the library a NUL is the end of the text, whatever comes after it.
  if (text.find('\0') != std::string_view::npos) return fail("is not valid JSON");
  TokenGuard guard;
  if (!read_tokens(text, guard)) return fail(guard.fault());
  return JsonValue(skip_spaces(text));
}

}  // namespace pointreel
