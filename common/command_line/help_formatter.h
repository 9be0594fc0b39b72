#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace pointreel {

/// Prints --help in 80 columns: the names of an option and its argument on the left, and on the
/// right its description, what it accepts, and its default. What the description already tells in
/// words ("default", the name of the variable in the environment) is not told again.
class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter();

  std::string make_group(std::string group, bool is_positional,
                         std::vector<const CLI::Option*> options) const override;
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
  std::string make_subcommand(const CLI::App* command) const override;
  std::string make_description(const CLI::App* app) const override;

 private:
  static constexpr std::size_t kColumn = 26;
};

/// Breaks a text between words into lines of at most `width` characters.
std::string wrap(const std::string& text, std::size_t width);

}  // namespace pointreel
