#include "common/command_line/toml.h"

#include <cstdint>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "common/base/try.h"

namespace pointreel::cli {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20;
/// In a line, and so in a key: toml++ makes a table of each part, and ends them by recursion.
constexpr int kMostDots = 1000;

auto fail_in(int line, const char* what) {
  return fail(ErrorCode::argument, fmt::format("line {}: {}", line, what));
}

/// A plain value as the command line has it; empty unless it is plain.
std::optional<std::string> text_of(const toml::node& node) {
  if (const auto text = node.value_exact<std::string>()) return *text;
  if (const auto number = node.value_exact<std::int64_t>()) return fmt::to_string(*number);
  if (const auto number = node.value_exact<double>()) return fmt::to_string(*number);
  if (const auto flag = node.value_exact<bool>()) return *flag ? "true" : "false";
  return std::nullopt;
}

Result<TomlSetting> setting_of(std::string_view table, const toml::key& key,
                               const toml::node& node) {
  constexpr const char* kNotPlain =
      "a value is text in quotes, a number, true, false, or a list of these";
  TomlSetting setting{std::string(table),
                      std::string(key.str()),
                      {},
                      node.is_boolean(),
                      static_cast<int>(key.source().begin.line)};
  const toml::array* list = node.as_array();
  for (std::size_t i = 0; i < (list == nullptr ? 1 : list->size()); ++i) {
    std::optional<std::string> text = text_of(list == nullptr ? node : (*list)[i]);
    if (!text) return fail_in(setting.line, kNotPlain);
    setting.values.push_back(*std::move(text));
  }
  return setting;
}

/// The first line with too many dots; 0 if there is none.
int crowded_line(std::string_view text) {
  int line = 1, dots = 0;
  for (const char letter : text) {
    if (letter == '.' && ++dots > kMostDots) return line;
    if (letter != '\n') continue;
    ++line;
    dots = 0;
  }
  return 0;
}

Result<std::vector<TomlSetting>> settings_in(const toml::table& file) {
  std::vector<TomlSetting> settings;
  for (const auto& [key, node] : file) {
    const toml::table* table = node.as_table();
    if (table == nullptr) {
      settings.push_back(TRY(setting_of("", key, node)));
      continue;
    }
    for (const auto& [name, value] : *table) settings.push_back(TRY(setting_of(key, name, value)));
  }
  return settings;
}

}  // namespace

Result<std::vector<TomlSetting>> parse_toml(std::string_view text) {
  if (text.size() > kMostBytes) return fail(ErrorCode::limit, "the file is larger than 1 MiB");
  if (const int line = crowded_line(text)) return fail_in(line, "this has too many dots");
  try {
    return settings_in(toml::parse(text));
  } catch (const toml::parse_error& error) {
    const bool repeated = error.description().find("redefine") != std::string_view::npos;
    return fail_in(static_cast<int>(error.source().begin.line),
                   repeated ? "this table or name is set a second time"
                            : "this is not TOML: NAME = VALUE, with text in quotes");
  }
}

}  // namespace pointreel::cli
