#include "codec/core/json_fields.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "codec/core/reel_rules.h"
#include "common/base/characters.h"
#include "common/base/concat.h"
#include "common/base/try.h"
#include "pointreel/cloud.h"

namespace pointreel {
namespace {

/// The name that no other file of a package may have.
constexpr std::string_view kManifest = "reel.json";

}  // namespace

Fields::Fields(const JsonValue& object) {
  if (!object.is_object()) error_ = Error{"is not a JSON object"};
  for (JsonItems item(object); item.next();) {
    if (members_.size() == kMaxMembers) {
      error_ = Error{concat("has more than ", kMaxMembers, " members"), ErrorCode::limit};
      return;
    }
    members_.push_back({item.key(), item.value()});
  }
}

Result<void> Fields::check() const {
  if (error_) return tl::unexpected(*error_);
  return {};
}

void Fields::refuse(std::string_view key, std::string_view what) {
  if (!error_) error_ = Error{concat(key, ": ", what)};
}

const JsonValue* Fields::find(const char* key) const {
  for (const Member& member : members_) {
    if (is_text(member.key, key)) return &member.value;
  }
  return nullptr;
}

const JsonValue* Fields::value(const char* key) {
  if (error_) return nullptr;
  const JsonValue* found = find(key);
  if (found == nullptr) refuse(key, "is missing");
  return found;
}

std::uint64_t Fields::integer(const char* key, std::uint64_t max) {
  const JsonValue* v = value(key);
  if (v == nullptr) return 0;
  const std::optional<std::uint64_t> number = v->integer();
  if (number && *number <= max) return *number;
  refuse(key, concat("is not a whole number from 0 to ", max));
  return 0;
}

double Fields::number(const char* key) {
  const JsonValue* v = value(key);
  if (v == nullptr) return 0.0;
  const std::optional<double> number = v->number();
  if (!number) refuse(key, "is not a number");
  return number.value_or(0.0);
}

bool Fields::boolean(const char* key) {
  const JsonValue* v = value(key);
  if (v == nullptr) return false;
  const std::optional<bool> boolean = v->boolean();
  if (!boolean) refuse(key, "is neither true nor false");
  return boolean.value_or(false);
}

std::string Fields::text(const char* key) {
  const JsonValue* v = value(key);
  if (v == nullptr) return {};
  std::optional<std::string> text = v->string();
  if (!text) refuse(key, "is not a string");
  return std::move(text).value_or(std::string());
}

JsonValue Fields::array(const char* key) {
  const JsonValue* v = value(key);
  if (v != nullptr && v->is_array()) return *v;
  if (v != nullptr) refuse(key, "is not an array");
  return JsonValue("[]");
}

glm::dvec3 Fields::vector(const char* key) {
  const JsonValue v = array(key);
  if (error_) return {};
  glm::dvec3 vector(0.0);
  int axis = 0;
  bool good = v.size() == 3;
  for (JsonItems item(v); good && item.next(); ++axis) {
    const std::optional<double> number = item.value().number();
    good = number && std::isfinite(*number);
    if (good) vector[axis] = *number;
  }
  if (good) return vector;
  refuse(key, "is not three finite numbers");
  return {};
}

bool is_file_name(std::string_view path) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  };
  return !path.empty() && path.size() <= kMaxTitle && path.front() != '.' && path != kManifest &&
         std::all_of(path.begin(), path.end(), allowed);
}

bool is_title(std::string_view text) { return text.size() <= kMaxTitle && is_harmless(text); }

std::optional<std::uint64_t> parse_hex(std::string_view text) {
  if (text.size() != 16) return std::nullopt;
  std::uint64_t value = 0;
  for (char c : text) {
    const bool digit = c >= '0' && c <= '9';
    if (!digit && !(c >= 'a' && c <= 'f')) return std::nullopt;
    value = value << 4 | static_cast<std::uint64_t>(digit ? c - '0' : c - 'a' + 10);
  }
  return value;
}

namespace {

/// A scalar field of a reel.
Result<ScalarRange> parse_scalar(const JsonValue& object) {
  Fields fields(object);
  ScalarRange range;
  range.name = fields.text("name");
  range.least = fields.number("min");
  range.most = fields.number("max");
  range.labels = fields.boolean("labels");
  TRY(fields.check());
  return range;
}

}  // namespace

void read_reel_head(Fields& fields, ReelHead& head) {
  head.name = fields.text("name");
  head.codec = fields.text("codec");
  if (head.codec == "octree" || head.codec == "video") {
    head.entropy = fields.text("entropy");
  } else if (fields.has("entropy")) {
    fields.refuse("entropy", "is given, but this codec has none");
  }
  if (fields.has("group_frames"))
    head.group_frames = static_cast<std::uint32_t>(fields.integer("group_frames", 0xffffffffu));
  head.fps = fields.number("fps");
  if (const auto up = parse_up(fields.text("up"))) {
    head.up = *up;
  } else {
    fields.refuse("up", concat("is not one of ", kUpNames));
  }
  head.colors = fields.boolean("colors");
  head.normals = fields.boolean("normals");
  if (fields.has("scalars")) {
    const JsonValue scalars = fields.array("scalars");
    if (scalars.size() > kMaxScalars)
      return fields.refuse("scalars", concat("has more than ", kMaxScalars, " fields"));
    for (JsonItems item(scalars); item.next();) {
      Result<ScalarRange> range = parse_scalar(item.value());
      if (!range) return fields.refuse("scalars", range.error().message);
      head.scalars.push_back(std::move(*range));
    }
  }
  const JsonValue layers = fields.array("layers");
  if (layers.size() > kMaxLayers) {
    return fields.refuse("layers", concat("has more than ", kMaxLayers, " names"));
  }
  for (JsonItems item(layers); item.next();) {
    std::optional<std::string> name = item.value().string();
    if (!name) return fields.refuse("layers", "a name is not a string");
    head.layer_names.push_back(std::move(*name));
  }
}

Result<Box> parse_box(const JsonValue& value) {
  if (value.is_null()) return Box{};
  Fields fields(value);
  const Box box{fields.vector("min"), fields.vector("max")};
  TRY(fields.check());
  TRY(check_box(box));
  return box;
}

}  // namespace pointreel
