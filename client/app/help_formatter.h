#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace pointreel {

/// Prints --help in 80 columns: names of an option and what it takes, its description beside them.
class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() { column_width(kColumn); }

  std::string make_option_name(const CLI::Option* option, bool is_positional) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;

 private:
  static constexpr std::size_t kColumn = 26;
};

/// The text in lines of at most `width` characters, broken between words. Its own line breaks stay.
std::string wrap(const std::string& text, std::size_t width);

}  // namespace pointreel
