#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/command_line/check.h"
#include "pointreel/error.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// Command lines, by CLI11. It takes 13 seconds to compile, so only cli11.cpp includes it. What is
/// here are handles, to be passed by value, to objects that the program owns; their functions do
/// what CLI11's functions of the same names do.
namespace pointreel::cli {

/// An option, a flag or an argument without dashes of a command.
class Option {
 public:
  Option() = default;  ///< no option
  explicit Option(CLI::Option* option) : option_(option) {}

  // To define it.
  Option allow_extra_args(bool allow) const;
  Option capture_default_str() const;
  Option check(const Check& check) const;
  Option default_str(const std::string& text) const;
  Option description(const std::string& text) const;
  Option envname(const std::string& name) const;
  Option excludes(Option other) const;
  Option expected(int least, int most) const;
  Option group(const std::string& name) const;  ///< without a name, it is not in --help
  /// Takes a size with a unit, too: 4M means 4 MiB.
  Option in_bytes() const;
  Option needs(Option other) const;
  Option required(bool required = true) const;
  Option type_name(const std::string& name) const;

  // What was given.
  std::size_t count() const;
  std::string value() const;
  const std::vector<std::string>& values() const;

  std::string name() const;  ///< "--output"
  std::string envname() const;
  bool is_flag() const;

  friend bool operator==(Option, Option) = default;

 private:
  CLI::Option* option_ = nullptr;
};

/// A program or one of its commands.
class Command {
 public:
  Command() = default;  ///< no command
  explicit Command(CLI::App* app) : app_(app) {}

  /// `value` is set when the command line is parsed. cli11.cpp lists the types that it may have.
  template <class T>
  Option add_option(const std::string& names, T& value, const std::string& description) const;
  template <class T>
  Option add_option_function(const std::string& names, const std::function<void(const T&)>& set,
                             const std::string& description) const;
  /// To be asked for its value.
  Option add_option(const std::string& names) const;
  Option add_flag(const std::string& names, bool& value, const std::string& description) const;
  Option add_flag(const std::string& names) const;
  Option add_flag_callback(const std::string& names, const std::function<void()>& set,
                           const std::string& description) const;
  /// An option of the program that names a file (TOML) of options of this command. Misspelt options
  /// are errors in the file, as they are on the command line.
  Option add_config(const std::string& names, const std::string& description) const;

  Command add_subcommand(const std::string& name, const std::string& description) const;
  void require_subcommand(std::size_t least, std::size_t most) const;
  void callback(const std::function<void()>& run) const;
  void footer(const std::string& text) const;
  void help_all_flag(const std::string& names, const std::string& description) const;
  /// Adds to the options that --help shows, in this order; --help-all then shows all.
  void essentials(const std::vector<std::string>& names) const;

  std::string name() const;
  std::string help() const;
  std::string help_all() const;
  std::vector<Option> options() const;
  std::vector<Command> subcommands() const;

  // What was given.
  bool parsed() const;
  std::size_t count(const std::string& name) const;  ///< of an option
  std::vector<Command> parsed_subcommands() const;

 protected:
  CLI::App* app_ = nullptr;
};

/// A program, which owns its commands and options.
class Program : public Command {
 public:
  explicit Program(const std::string& description = {}, const std::string& name = {});
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Gives the program, and the subcommands that it has by now, the help and --version that all
  /// programs have, and the program --write-manuals. Its name is that of the program.
  void add_common_options();

  /// Parses the command line and runs the subcommand that it names.
  Result<void> parse(const std::vector<std::string>& arguments);
  /// The same for main(), after preparing the process. If the program has nothing more to do,
  /// because it has printed its help, or what is wrong in one line, the result is its exit status:
  /// 0, 2 for a wrong command line, or 1 if the subcommand threw an exception.
  std::optional<int> parse(int argc, const char* const* argv);

 private:
  std::unique_ptr<CLI::App> owned_;
};

}  // namespace pointreel::cli
