#include "client/options/settings_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <string>
#include <system_error>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "client/options/option_table.h"
#include "client/options/option_text.h"
#include "common/base/json_value.h"
#include "common/base/try.h"
#include "common/file_system/user_folder.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::uintmax_t kMaxBytes = 64 * 1024;
constexpr const char* kMendIt = ": write an object such as {\"mode\": \"voxel\"}, or delete it";

json to_json(const Option::Flag& flag, const Settings& from) { return flag.get(from); }
json to_json(const Option::Number& number, const Settings& from) { return number.get(from); }
json to_json(const Option::Choice& choice, const Settings& from) {
  return choice.names[choice.get(from)];
}
json to_json(const Option::Color& color, const Settings& from) {
  return color_text(color.get(from));
}
json to_json(const Option::Size& size, const Settings& from) {
  const glm::ivec2 pixels = size.get(from);
  return {pixels.x, pixels.y};
}

// The message of an error follows the value: "is not ...".

Result<void> set(const Option::Flag& flag, const json& value, Settings& to) {
  if (!value.is_boolean()) return fail("is neither true nor false");
  flag.set(to, value.get<bool>());
  return {};
}

Result<void> set(const Option::Number& number, const json& value, Settings& to) {
  const double given = value.is_number() ? value.get<double>() : std::nan("");
  if (!number.range.contains(given))
    return fail(
        fmt::format("is not a number from {:g} to {:g}", number.range.min, number.range.max));
  number.set(to, given);
  return {};
}

Result<void> set(const Option::Choice& choice, const json& value, Settings& to) {
  const auto& names = choice.names;
  const auto found = std::find(names.begin(), names.end(),
                               value.is_string() ? value.get_ref<const std::string&>() : "");
  if (found == names.end()) return fail(fmt::format("is not one of {}", fmt::join(names, ", ")));
  choice.set(to, static_cast<std::size_t>(found - names.begin()));
  return {};
}

Result<void> set(const Option::Color& color, const json& value, Settings& to) {
  const std::string text = value.is_string() ? value.get<std::string>() : "";
  const auto parsed = parse_color(text);
  if (!text.starts_with('#') || !parsed) return fail("is not a colour such as \"#1c1f24\"");
  color.set(to, *parsed);
  return {};
}

Result<void> set(const Option::Size& size, const json& value, Settings& to) {
  const Range& range = size.range;
  const auto is_side = [&](const json& side) {
    return side.is_number_integer() && side >= range.min && side <= range.max;
  };
  if (!value.is_array() || value.size() != 2 || !is_side(value[0]) || !is_side(value[1]))
    return fail(fmt::format("is not a size such as [1280, 720] with sides from {:g} to {:g}",
                            range.min, range.max));
  size.set(to, {value[0].get<int>(), value[1].get<int>()});
  return {};
}

/// The value of an option in a file, also where the file calls it by its earlier name.
json::const_iterator find_value(const json& all, const Option& option) {
  const auto found = all.find(option.name);
  return found == all.end() && !option.old_name.empty() ? all.find(option.old_name) : found;
}

/// Empty if there is no such file.
Result<std::string> content(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) return std::string();
  // Reading a pipe or a device might never end, or never begin.
  if (status.type() != fs::file_type::regular) return fail(ErrorCode::io, "is not a regular file");
  std::ifstream in(file, std::ios::binary);
  std::string text(kMaxBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad() || !in.is_open()) return fail(ErrorCode::io, "cannot be read");
  if (static_cast<std::uintmax_t>(in.gcount()) > kMaxBytes)
    return fail(ErrorCode::limit, fmt::format("has more than {} bytes", kMaxBytes));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

Result<json> parse(std::string_view text) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) return json::object();
  const auto checked = parse_json(text);
  if (!checked) return fail(checked.error().code, checked.error().message + kMendIt);
  if (!checked->is_object()) return fail(std::string("is not a JSON object") + kMendIt);
  // The file is small, and what this version does not know stays in it when it is written again.
  return json::parse(text, nullptr, false);
}

/// Readers see either the old file or the new one, never a part of it.
Result<void> replace(const fs::path& file, const std::string& text) {
  std::error_code error;
  // A symbolic link stays a link: people keep their settings in other places.
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
  return fail(ErrorCode::io, "cannot be written" + (error ? ": " + error.message() : ""));
}

}  // namespace

fs::path default_settings_file() {
  const fs::path folder = user_folder("XDG_CONFIG_HOME", ".config");
  return folder.empty() ? fs::path() : folder / "player.json";
}

Result<void> parse_settings(std::string_view text, Settings& settings) {
  const json all = TRY(parse(text));
  Settings changed = settings;
  for (const Option& option : option_table()) {
    const auto found = find_value(all, option);
    if (found == all.end()) continue;
    const auto done =
        std::visit([&](const auto& value) { return set(value, *found, changed); }, option.value);
    if (!done)
      return fail(
          fmt::format("\"{}\": {} {}", found.key(),
                      found->dump(-1, ' ', true, json::error_handler_t::replace).substr(0, 60),
                      done.error().message));
  }
  settings = changed;
  return {};
}

Result<void> read_settings(const fs::path& file, Settings& settings) {
  const auto text = content(file);
  const auto read = text ? parse_settings(*text, settings) : tl::unexpected(text.error());
  if (!read) return fail_at(file.string(), read.error());
  return {};
}

Result<void> write_settings(const fs::path& file, const Settings& begun, const Settings& ended) {
  const auto value_of = [](const Option& option, const Settings& from) {
    return std::visit([&](const auto& value) { return to_json(value, from); }, option.value);
  };
  std::vector<const Option*> changed;
  for (const Option& option : option_table())
    if (value_of(option, ended) != value_of(option, begun)) changed.push_back(&option);
  if (changed.empty()) return {};
  // The file is read again because another window may have written it in the meantime.
  const auto text = content(file);
  auto all = text ? parse(*text) : tl::unexpected(text.error());
  if (!all) return fail_at(file.string(), all.error());
  for (const Option* option : changed) {
    if (!option->old_name.empty()) all->erase(std::string(option->old_name));
    (*all)[std::string(option->name)] = value_of(*option, ended);
  }
  const auto written =
      replace(file, all->dump(2, ' ', false, json::error_handler_t::replace) + "\n");
  if (!written) return fail_at(file.string(), written.error());
  return {};
}

}  // namespace pointreel
