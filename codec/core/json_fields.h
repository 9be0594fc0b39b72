#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/json_value.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "pointreel/package.h"

/// Reads the JSON of packages, live streams and camera paths.
///
/// Trust: the texts may be hostile (json_value.h). Objects of more than kMaxMembers members are
/// refused where members are looked for, so that looking for one takes a bounded time.
namespace pointreel {

/// The largest whole number that is exact in readers that hold every number as a double, as
/// JavaScript does.
inline constexpr std::uint64_t kMaxInteger = (std::uint64_t{1} << 53) - 1;
/// The greatest length of the name of a file or of a reel, in bytes.
inline constexpr std::size_t kMaxTitle = 255;
inline constexpr std::size_t kMaxLayers = 8;
/// The greatest length of a layer's name, in bytes. It is part of the names of files.
inline constexpr std::size_t kMaxLayerName = 64;
/// The value of "format" in reel.json.
inline constexpr const char* kPackageFormat = "pointreel";

/// The most members that an object may have, counting those that are not known.
inline constexpr std::size_t kMaxMembers = 1000;

/// Reads the members of one JSON object. The first one that is not as expected is kept as the
/// error, and all values after it are zero, so that a parser needs to check only once, after the
/// last member.
class Fields {
 public:
  explicit Fields(const JsonValue& object);

  const std::optional<Error>& error() const { return error_; }
  /// The error, if there is one, for TRY.
  Result<void> check() const;
  /// Records an error about a member, unless there already is an error.
  void refuse(std::string_view key, std::string_view what);

  bool has(const char* key) const { return !error_ && find(key) != nullptr; }
  /// Null if the member is missing.
  const JsonValue* value(const char* key);
  std::uint64_t integer(const char* key, std::uint64_t max);
  double number(const char* key);
  bool boolean(const char* key);
  std::string text(const char* key);
  /// Empty if the member is not an array.
  JsonValue array(const char* key);
  /// Three finite numbers.
  glm::dvec3 vector(const char* key);

 private:
  struct Member {
    JsonValue key, value;
  };

  const JsonValue* find(const char* key) const;

  std::vector<Member> members_;
  std::optional<Error> error_;
};

/// True if the name is that of a plain file in the package's own folder on every system.
bool is_file_name(std::string_view path);

/// True if the text may be shown to people: at most kMaxTitle bytes of harmless
/// characters (common/base/characters.h).
bool is_title(std::string_view text);

/// Reads 16 lowercase hexadecimal digits, the most significant first.
std::optional<std::uint64_t> parse_hex(std::string_view text);

/// Reads the members that packages and live streams have in common, and checks their types. An
/// error is left in `fields`. Their values are left to check_head (reel_rules.h).
void read_reel_head(Fields& fields, ReelHead& head);

/// Reads `{"min": [x, y, z], "max": [x, y, z]}`, or null for an empty box, and checks it.
Result<Box> parse_box(const JsonValue& value);

}  // namespace pointreel
