#include "common/stream/json_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <set>
#include <utility>

#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

/// Far above the nesting of a manifest, which is six.
constexpr int kMaxNesting = 16;
/// The name that no other file of a package may have.
constexpr std::string_view kManifest = "reel.json";

/// Checks every token before it becomes a value: values that are nested too deep are not built, and
/// an object with the same key twice, which the parser alone would accept, is noticed.
class TokenGuard {
 public:
  bool operator()(int depth, json::parse_event_t event, const json& parsed) {
    switch (event) {
      case json::parse_event_t::object_start:
      case json::parse_event_t::array_start:
        if (depth >= kMaxNesting) {
          too_deep_ = true;
          return false;
        }
        keys_[static_cast<std::size_t>(depth) + 1].clear();
        return true;
      case json::parse_event_t::key:
        if (depth <= kMaxNesting &&
            !keys_[static_cast<std::size_t>(depth)].insert(parsed.get<std::string>()).second) {
          duplicate_ = true;
        }
        return true;
      default:
        return true;
    }
  }

  const char* fault() const {
    if (too_deep_) return "is nested too deep";
    return duplicate_ ? "has an object with the same key twice" : nullptr;
  }

 private:
  std::array<std::set<std::string>, kMaxNesting + 1> keys_;
  bool too_deep_ = false, duplicate_ = false;
};

}  // namespace

Result<json> parse_json(std::string_view text) {
  TokenGuard guard;
  json root = json::parse(text.begin(), text.end(), std::ref(guard), false);
  if (guard.fault() != nullptr) return fail(guard.fault());
  if (root.is_discarded()) return fail("is not valid JSON");
  return root;
}

std::string dump(const ordered_json& value) {
  return value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

Fields::Fields(const json& object) : object_(object) {
  if (!object.is_object()) error_ = Error{"is not a JSON object"};
}

Result<void> Fields::check() const {
  if (error_) return tl::unexpected(*error_);
  return {};
}

void Fields::refuse(std::string_view key, std::string_view what) {
  if (!error_) error_ = Error{concat(key, ": ", what)};
}

const json* Fields::value(const char* key) {
  if (error_) return nullptr;
  const auto found = object_.find(key);
  if (found != object_.end()) return &*found;
  refuse(key, "is missing");
  return nullptr;
}

std::uint64_t Fields::integer(const char* key, std::uint64_t max) {
  const json* v = value(key);
  if (v == nullptr) return 0;
  if (!v->is_number_unsigned() || v->get<std::uint64_t>() > max) {
    refuse(key, concat("is not a whole number from 0 to ", max));
    return 0;
  }
  return v->get<std::uint64_t>();
}

double Fields::number(const char* key) {
  const json* v = value(key);
  if (v == nullptr) return 0.0;
  if (!v->is_number()) refuse(key, "is not a number");
  return v->is_number() ? v->get<double>() : 0.0;
}

bool Fields::boolean(const char* key) {
  const json* v = value(key);
  if (v == nullptr) return false;
  if (!v->is_boolean()) refuse(key, "is neither true nor false");
  return v->is_boolean() && v->get<bool>();
}

std::string Fields::text(const char* key) {
  const json* v = value(key);
  if (v == nullptr) return {};
  if (!v->is_string()) refuse(key, "is not a string");
  return v->is_string() ? v->get<std::string>() : std::string();
}

const json& Fields::array(const char* key) {
  static const json kNothing = json::array();
  const json* v = value(key);
  if (v == nullptr) return kNothing;
  if (!v->is_array()) refuse(key, "is not an array");
  return v->is_array() ? *v : kNothing;
}

glm::dvec3 Fields::vector(const char* key) {
  const json& v = array(key);
  if (error_) return {};
  const auto finite = [](const json& x) { return x.is_number() && std::isfinite(x.get<double>()); };
  if (v.size() != 3 || !std::all_of(v.begin(), v.end(), finite)) {
    refuse(key, "is not three finite numbers");
    return {};
  }
  return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()};
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

Result<std::vector<std::string>> parse_layer_names(const json& entries) {
  if (entries.empty() || entries.size() > kMaxLayers) {
    return fail(concat("has ", entries.size(), " names, not 1 to ", kMaxLayers));
  }
  std::vector<std::string> names;
  for (const json& entry : entries) {
    if (!entry.is_string() || !is_file_name(entry.get_ref<const std::string&>())) {
      return fail("a name may have only letters, digits, '.', '_' and '-'");
    }
    const std::string& layer = entry.get_ref<const std::string&>();
    if (std::find(names.begin(), names.end(), layer) != names.end()) {
      return fail(concat("\"", layer, "\" comes twice"));
    }
    names.push_back(layer);
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
  const json& layers = fields.array("layers");
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

Result<Box> parse_box(const json& value) {
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
