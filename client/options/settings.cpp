#include "client/options/settings.h"

#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "client/scene/frame.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::uintmax_t kMaxBytes = 64 * 1024;

/// What a number may be.
struct Range {
  double min = 0.0, max = 0.0;
};

json value_of(bool on) { return on; }
json value_of(const std::optional<bool>& on) { return on.value_or(true); }
json value_of(double number) { return number; }
/// With the digits that tell it from other floats and no more: 0.1, not 0.10000000149.
json value_of(float number) { return std::stod(fmt::format("{}", number)); }
json value_of(const glm::ivec2& size) { return {size.x, size.y}; }
json value_of(const glm::vec3& color) {
  const glm::ivec3 c(glm::round(glm::clamp(color, 0.0f, 1.0f) * 255.0f));
  return fmt::format("#{:02x}{:02x}{:02x}", c.r, c.g, c.b);
}
template <class Enum>
  requires std::is_enum_v<Enum>
json value_of(Enum value) {
  return name(value);
}

template <class Bool>
  requires std::is_same_v<Bool, bool> || std::is_same_v<Bool, std::optional<bool>>
Result<void> take(const json& value, Range, Bool& on) {
  if (!value.is_boolean()) return fail("is neither true nor false");
  on = value.get<bool>();
  return {};
}

template <std::floating_point Number>
Result<void> take(const json& value, Range range, Number& number) {
  const double given = value.is_number() ? value.get<double>() : std::nan("");
  if (!(given >= range.min && given <= range.max))
    return fail(fmt::format("is no number from {:g} to {:g}", range.min, range.max));
  number = static_cast<Number>(given);
  return {};
}

Result<void> take(const json& value, Range range, glm::ivec2& size) {
  const auto is_edge = [&](const json& edge) {
    return edge.is_number_integer() && edge >= range.min && edge <= range.max;
  };
  if (!value.is_array() || value.size() != 2 || !is_edge(value[0]) || !is_edge(value[1]))
    return fail(fmt::format("is no size such as [1280, 720], from {:g} to {:g} a side", range.min,
                            range.max));
  size = {value[0].get<int>(), value[1].get<int>()};
  return {};
}

Result<void> take(const json& value, Range, glm::vec3& color) {
  const std::string text = value.is_string() ? value.get<std::string>() : "";
  if (text.size() != 7 || text[0] != '#' ||
      text.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos)
    return fail("is no colour such as \"#1c1f24\"");
  for (int i = 0; i < 3; ++i)
    color[i] = static_cast<float>(std::stoi(text.substr(1 + 2 * i, 2), nullptr, 16)) / 255.0f;
  return {};
}

/// An enum's values, by their names; as many as `range.max`.
template <class Enum>
  requires std::is_enum_v<Enum>
Result<void> take(const json& value, Range range, Enum& named) {
  std::string all;
  for (int i = 0; i < static_cast<int>(range.max); ++i) {
    const auto candidate = static_cast<Enum>(i);
    if (value.is_string() && value.get_ref<const std::string&>() == name(candidate)) {
      named = candidate;
      return {};
    }
    all += fmt::format("{}{}", i > 0 ? ", " : "", name(candidate));
  }
  return fail("is none of " + all);
}

struct Setting {
  std::string_view name;
  std::string_view option;  ///< empty: the command line has none
  Range range;
  json (*get)(const PlayOptions&);
  Result<void> (*set)(const json&, Range, PlayOptions&);
};

/// Of the member that `Member` finds in options.
template <class Member>
Setting setting(std::string_view name, std::string_view option, Member, Range range = {}) {
  return {name, option, range, [](const PlayOptions& from) { return value_of(Member{}(from)); },
          [](const json& value, Range within, PlayOptions& to) {
            return take(value, within, Member{}(to));
          }};
}

/// All there are, with the command line's bounds.
std::span<const Setting> settings() {
  static const std::array kSettings = {
      setting("window", "", [](auto& o) -> auto& { return o.size; }, {64, 16384}),
      setting("loop", "loop", [](auto& o) -> auto& { return o.loop; }),
      setting("mode", "mode", [](auto& o) -> auto& { return o.draw.mode; }, {0, 3}),
      setting("instancing", "instancing", [](auto& o) -> auto& { return o.draw.instancing; },
              {0, kInstancings}),
      setting("splatting", "splatting", [](auto& o) -> auto& { return o.draw.splatting; },
              {0, kSplattings}),
      setting("visibility_scale", "visibility-scale",
              [](auto& o) -> auto& { return o.draw.scales.visibility; }, {0.01, 100}),
      setting("shading_scale", "shading-scale",
              [](auto& o) -> auto& { return o.draw.scales.shading; }, {0.01, 100}),
      setting("fill_holes", "fill-holes", [](auto& o) -> auto& { return o.draw.fill_holes; }),
      setting("delta", "delta", [](auto& o) -> auto& { return o.delta; }, {0, 1}),
      setting("edl", "edl", [](auto& o) -> auto& { return o.draw.edl; }, {0, 100}),
      setting("color", "color", [](auto& o) -> auto& { return o.draw.color; }, {0, kColorSources}),
      setting("point_size", "point-size", [](auto& o) -> auto& { return o.draw.point_size; },
              {1, 64}),
      setting("lighting", "lighting", [](auto& o) -> auto& { return o.draw.lighting; }),
      setting("pixel_size", "pixel-size", [](auto& o) -> auto& { return o.draw.pixel_size; },
              {0, 1000}),
      setting("drafts", "drafts", [](auto& o) -> auto& { return o.drafts; }, {0, kDrafts}),
      setting("background", "background", [](auto& o) -> auto& { return o.draw.background; }),
      setting("floor", "floor", [](auto& o) -> auto& { return o.floor; }),
      setting("drawing_panel", "", [](auto& o) -> auto& { return o.drawing_panel; }),
      setting("statistics_panel", "", [](auto& o) -> auto& { return o.statistics_panel; }),
  };
  return kSettings;
}

/// What is in it; empty where there is no such file.
Result<std::string> content(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) return std::string();
  // Anything else might never end, or never begin.
  if (status.type() != fs::file_type::regular) return fail("is no file that can be read");
  std::ifstream in(file, std::ios::binary);
  std::string text(kMaxBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad() || !in.is_open()) return fail("cannot be read");
  if (static_cast<std::uintmax_t>(in.gcount()) > kMaxBytes)
    return fail(fmt::format("has more than {} bytes", kMaxBytes));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

Result<json> parse(std::string_view text) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) return json::object();
  json all = json::parse(text, nullptr, false);
  if (!all.is_object())
    return fail("is no JSON object such as {\"mode\": \"voxel\"}; mend it or delete it");
  return all;
}

/// So that whoever reads it while it is written reads the old one or the new one.
Result<void> replace(const fs::path& file, const std::string& text) {
  std::error_code error;
  // A link stays one: people keep such files elsewhere.
  fs::path target = fs::weakly_canonical(file, error);
  if (error) target = file;
  fs::create_directories(target.parent_path(), error);
  const fs::path unfinished = fmt::format("{}.{}~", target.string(), ::getpid());
  std::ofstream out(unfinished, std::ios::binary);
  out << text;
  out.close();
  if (out) fs::rename(unfinished, target, error);
  if (out && !error) return {};
  std::error_code ignored;
  fs::remove(unfinished, ignored);
  return fail("cannot be written" + (error ? ": " + error.message() : ""));
}

}  // namespace

fs::path default_settings_file() {
  const char *config = std::getenv("XDG_CONFIG_HOME"), *home = std::getenv("HOME");
  // Relative ones are invalid, says the XDG Base Directory Specification.
  if (config != nullptr && config[0] == '/') return fs::path(config) / "pointreel/player.json";
  if (home != nullptr && home[0] == '/') return fs::path(home) / ".config/pointreel/player.json";
  return {};
}

Result<void> parse_settings(std::string_view text, const GivenOption& given, PlayOptions& options) {
  const auto all = parse(text);
  if (!all) return tl::unexpected(all.error());
  PlayOptions changed = options;
  for (const Setting& setting : settings()) {
    const auto found = all->find(setting.name);
    if (found == all->end()) continue;
    // Checked even where it is not wanted, so that errors do not come and go.
    PlayOptions ignored;
    const bool wanted = setting.option.empty() || !given(setting.option);
    const auto set = setting.set(*found, setting.range, wanted ? changed : ignored);
    if (!set)
      return fail(
          fmt::format("\"{}\": {} {}", setting.name,
                      found->dump(-1, ' ', true, json::error_handler_t::replace).substr(0, 60),
                      set.error().message));
  }
  options = std::move(changed);
  return {};
}

Result<void> read_settings(const fs::path& file, const GivenOption& given, PlayOptions& options) {
  const auto text = content(file);
  const auto read = text ? parse_settings(*text, given, options) : tl::unexpected(text.error());
  if (!read) return fail_at(file.string(), read.error());
  return {};
}

Result<void> write_settings(const fs::path& file, const PlayOptions& begun,
                            const PlayOptions& ended) {
  json changed = json::object();
  for (const Setting& setting : settings()) {
    const json now = setting.get(ended);
    if (now != setting.get(begun)) changed[std::string(setting.name)] = now;
  }
  if (changed.empty()) return {};
  // As it is now: another window may have written it meanwhile.
  const auto text = content(file);
  auto all = text ? parse(*text) : tl::unexpected(text.error());
  if (!all) return fail_at(file.string(), all.error());
  all->update(changed);
  const auto written =
      replace(file, all->dump(2, ' ', false, json::error_handler_t::replace) + "\n");
  if (!written) return fail_at(file.string(), written.error());
  return {};
}

}  // namespace pointreel
