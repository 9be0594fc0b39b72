#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>
#include <system_error>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

/// Checks of options that CLI11 lacks.
namespace pointreel {

/// Accepts the numbers for which `good` holds; `what` describes them. CLI::Range and
/// CLI::PositiveNumber let NaN pass, because they ask whether a number is out of range: use these
/// for every option with a fraction.
template <class Good>
CLI::Validator number_option(std::string what, Good good) {
  const auto check = [what = std::move(what), good](const std::string& text) {
    double value = 0.0;
    if (CLI::detail::lexical_cast(text, value) && good(value)) return std::string();
    return fmt::format("{} is not {}", text, what);
  };
  return CLI::Validator(check, "");
}

inline CLI::Validator number_within(double least, double most) {
  return number_option(fmt::format("a number from {:.10g} to {:.10g}", least, most),
                       [=](double value) { return value >= least && value <= most; });
}

inline CLI::Validator positive_number() {
  return number_option("a number above 0",
                       [](double value) { return value > 0.0 && std::isfinite(value); });
}

/// Accepts the numbers of 64 bits. Without it, CLI11 takes -1 and numbers that do not fit for the
/// largest one.
inline CLI::Validator whole_number() {
  const auto check = [](const std::string& text) {
    std::uint64_t value = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error == std::errc() && stop == end) return std::string();
    return fmt::format("{} is not a whole number from 0 to {}", text,
                       std::numeric_limits<std::uint64_t>::max());
  };
  return CLI::Validator(check, "");
}

/// What is wrong with the value of an option for a token, on the command line, in a configuration
/// file or in the environment; empty if nothing. Somebody who sets a token to nothing, as in
/// "--token $UNSET", does not mean that none is needed.
inline std::string fault_of_token(const CLI::Option& option) {
  const std::string variable = option.get_envname();
  const char* environment = variable.empty() ? nullptr : std::getenv(variable.c_str());
  std::string place = option.get_name();
  std::string token = "unset";
  if (option.count() > 0) {
    token = option.as<std::string>();
  } else if (environment != nullptr) {
    place = variable;
    token = environment;
  }
  if (token.empty()) return place + ": is empty; give a token, or leave it out";
  for (const char c : token) {
    if (static_cast<unsigned char>(c) <= ' ' || c == 127) {
      return place + ": has a space or a control character, which no token may have";
    }
  }
  return {};
}

}  // namespace pointreel
