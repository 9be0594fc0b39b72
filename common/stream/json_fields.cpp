#include "common/stream/json_fields.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

using nlohmann::ordered_json;

/// The name that no other file of a package may have.
constexpr std::string_view kManifest = "reel.json";

}  // namespace

std::string dump(const ordered_json& value) {
  return value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

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

bool is_title(std::string_view text) {
  return text.size() <= kMaxTitle && std::none_of(text.begin(), text.end(), [](char c) {
           return static_cast<unsigned char>(c) < 32 || c == 127;
         });
}

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

Result<std::vector<std::string>> parse_layer_names(const JsonValue& entries) {
  const std::size_t count = entries.size();
  if (count == 0 || count > kMaxLayers) {
    return fail(concat("has ", count, " names, not 1 to ", kMaxLayers));
  }
  std::vector<std::string> names;
  for (JsonItems item(entries); item.next();) {
    const std::optional<std::string> layer = item.value().string();
    if (!layer || !is_file_name(*layer)) {
      return fail("a name may have only letters, digits, '.', '_' and '-'");
    }
    if (std::find(names.begin(), names.end(), *layer) != names.end()) {
      return fail(concat("\"", *layer, "\" comes twice"));
    }
    names.push_back(*layer);
  }
  return names;
}

void read_reel_head(Fields& fields, ReelHead& head) {
  head.name = fields.text("name");
  head.codec = fields.text("codec");
  head.fps = fields.number("fps");
  const std::string up = fields.text("up");
  head.colors = fields.boolean("colors");
  head.normals = fields.boolean("normals");
  const JsonValue layers = fields.array("layers");
  if (head.codec == "octree") {
    head.entropy = fields.text("entropy");
    if (head.entropy != "none" && head.entropy != "zstd" && head.entropy != "context") {
      fields.refuse("entropy", "is not \"none\", \"zstd\" or \"context\"");
    }
  } else if (head.codec != "draco") {
    fields.refuse("codec", "is neither \"octree\" nor \"draco\"");
  } else if (fields.has("entropy")) {
    fields.refuse("entropy", "is given, but only the octree codec has one");
  }
  if (!is_title(head.name)) {
    fields.refuse("name", concat("has more than ", kMaxTitle, " bytes, or a control character"));
  }
  if (!(head.fps > 0.0 && head.fps <= kMaxFps)) {
    fields.refuse("fps", "is not a number above 0 and at most 1000000");
  }
  if (up != "y" && up != "z") fields.refuse("up", "is neither \"y\" nor \"z\"");
  if (fields.error()) return;
  head.up = up.front();
  if (auto names = parse_layer_names(layers))
    head.layer_names = std::move(*names);
  else
    fields.refuse("layers", names.error().message);
}

Result<Box> parse_box(const JsonValue& value) {
  if (value.is_null()) return Box{};
  Fields fields(value);
  const Box box{fields.vector("min"), fields.vector("max")};
  TRY(fields.check());
  if (!(box.min.x <= box.max.x && box.min.y <= box.max.y && box.min.z <= box.max.z)) {
    return fail("min is beyond max");
  }
  return box;
}

ordered_json box_json(const Box& box) {
  if (box.empty()) return nullptr;
  return {{"min", vector_json(box.min)}, {"max", vector_json(box.max)}};
}

ordered_json vector_json(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

}  // namespace pointreel
