#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace pointreel::cli {

/// What an option accepts.
struct Check {
  /// What is wrong with a value; empty if nothing.
  std::function<std::string(const std::string&)> fault;
  /// For --help, manual pages and completions (option_words.h), in CLI11's words: "FILE",
  /// "{auto,kd-tree}" or "INT in [0 - 21]". If it is empty, the description of the option says it.
  std::string accepts = {};
};

/// Both ends are included. T is int, unsigned, std::size_t or double; but use number_within for
/// fractions, because this lets NaN pass: it asks whether a number is out of range.
template <class T>
Check range(T least, T most);
Check one_of(const std::vector<std::string>& words);
Check existing_file();
/// Refuses the empty text, which a script gives whose variable is not set. `what` is missing.
Check not_empty(const std::string& what);

/// Accepts the numbers for which `good` holds; `what` describes them.
Check number_option(const std::string& what, std::function<bool(double)> good);
Check number_within(double least, double most);
/// Accepts finite numbers above 0.
Check positive_number();
/// Accepts the numbers of 64 bits. Without it, CLI11 takes -1 and numbers that do not fit for the
/// largest one.
Check whole_number();

/// Accepts what `parse` returns a Result for; its error is the message.
template <class Parse>
Check parsed_by(Parse parse) {
  return {[parse](const std::string& text) {
    const auto result = parse(text);
    return result ? std::string() : result.error().message;
  }};
}

/// A number as options read it.
std::optional<double> number_of(const std::string& text);

}  // namespace pointreel::cli
