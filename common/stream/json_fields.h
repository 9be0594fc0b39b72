#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "pointreel/package.h"

/// What the JSON of packages and of live streams has in common. Included by their parsers alone.
///
/// Trust: the texts may be hostile. What nests deeper than 16 is not built, a key that comes twice
/// is refused, and memory is bounded by the text's length.
namespace pointreel {

/// Whole numbers stay exact in readers that hold every number as a double, as JavaScript does.
inline constexpr std::uint64_t kMaxInteger = (std::uint64_t{1} << 53) - 1;
/// Bytes of a name, of a file as of a reel.
inline constexpr std::size_t kMaxTitle = 255;
inline constexpr std::size_t kMaxLayers = 8;
/// The value of "format" in reel.json.
inline constexpr const char* kPackageFormat = "pointreel";

Result<nlohmann::json> parse_json(std::string_view text);

/// On one line. Bytes that are no UTF-8, in a name, are replaced: it never throws.
std::string dump(const nlohmann::ordered_json& value);

/// The members of one JSON object. The first thing that is not as it should be is kept as the
/// error, and every value after it is zero, so that a parser checks once, after the last member.
class Fields {
 public:
  explicit Fields(const nlohmann::json& object);

  const std::optional<Error>& error() const { return error_; }
  void refuse(std::string_view key, std::string_view what);

  bool has(const char* key) const { return !error_ && object_.contains(key); }
  const nlohmann::json* value(const char* key);
  std::uint64_t integer(const char* key, std::uint64_t max);
  double number(const char* key);
  bool boolean(const char* key);
  std::string text(const char* key);
  /// Empty where it is no array.
  const nlohmann::json& array(const char* key);
  /// Three finite numbers.
  glm::dvec3 vector(const char* key);

 private:
  const nlohmann::json& object_;
  std::optional<Error> error_;
};

/// A name that is a plain file in the package's own folder on every system.
bool is_file_name(std::string_view path);

/// What may be shown to people: at most kMaxTitle bytes and no control character.
bool is_title(std::string_view text);

/// 16 lowercase hexadecimal digits, the highest first.
std::optional<std::uint64_t> parse_hex(std::string_view text);

/// 1 to kMaxLayers names, made like file names, no two alike.
Result<std::vector<std::string>> parse_layer_names(const nlohmann::json& entries);

/// What packages and live streams both begin with; what is wrong with it is the fields' error.
void read_reel_head(Fields& fields, ReelHead& head);

/// `{"min": [x, y, z], "max": [x, y, z]}`, or null for an empty box.
Result<Box> parse_box(const nlohmann::json& value);
nlohmann::ordered_json box_json(const Box& box);
nlohmann::ordered_json vector_json(const glm::dvec3& v);

}  // namespace pointreel
