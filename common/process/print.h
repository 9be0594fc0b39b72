#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

/// The only way in which programs print for people. File names, names of reels and answers of
/// servers may hold anything, even characters that move a terminal's cursor, rename its window or
/// reverse the direction of writing. All of them are shown as visible text.
namespace pointreel {

/// Text of any origin as it may be printed. Control characters (C0, DEL and C1), characters that
/// change the direction of writing or break lines, and bytes that are not UTF-8 become escapes:
/// "\n", "\x1b", "\u009b". What may be printed stays as it is, backslashes too, so the result
/// cannot be read back; applied to itself it changes nothing.
///
/// Trust: the text may be hostile. The result is at most six times as long.
std::string visible(std::string_view text);

/// `visible` for text, and anything else as it is: an argument for a format string.
template <class T>
decltype(auto) as_visible(const T& value) {
  if constexpr (std::is_convertible_v<const T&, std::string_view>)
    return visible(value);
  else
    return (value);
}

template <class T>
using Visible = decltype(as_visible(std::declval<const T&>()));

/// fmt::format with all its text arguments made visible. Lines are broken only where the format
/// string says so.
template <class... T>
std::string format_visible(fmt::format_string<Visible<T>...> format, const T&... arguments) {
  return fmt::format(format, as_visible(arguments)...);
}

/// The same, to standard output.
template <class... T>
void print(fmt::format_string<Visible<T>...> format, const T&... arguments) {
  const std::string text = fmt::format(format, as_visible(arguments)...);
  std::fwrite(text.data(), 1, text.size(), stdout);
}

/// Prints text of several lines, as a report has, on standard output. False if that cannot be
/// written.
bool print_lines(std::string_view text);

/// Prints "PROGRAM: message" as one line on standard error, without secrets of addresses
/// (hide_secrets).
void print_error(std::string_view program, std::string_view message);

/// JSON on standard output, in ASCII: its own escapes stand for everything else. Bytes that are not
/// UTF-8 are replaced.
template <class Json>
void print_json(const Json& json, int indent = 2) {
  const std::string text = json.dump(indent, ' ', true, Json::error_handler_t::replace) + "\n";
  std::fwrite(text.data(), 1, text.size(), stdout);
}

}  // namespace pointreel
