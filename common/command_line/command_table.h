#pragma once

#include <string>
#include <vector>

/// What --help, manual pages and completions are made of.
namespace pointreel::cli {

/// An option or an argument, as it was defined.
struct OptionEntry {
  /// "-o", "--output"; a flag with its negation, "--loop", "--no-loop"; the name of an argument
  /// without dashes.
  std::vector<std::string> names;
  bool positional = false;  ///< without dashes
  bool has_place = false;   ///< it may be given without its name
  /// Its argument and its checks, in CLI11's words: "INT:INT in [0 - 21]"; see option_words.h.
  std::string type;
  int least_values = 0;  ///< 0: it may stand without its value, as in --json [FILE], or is a flag
  int most_values = 0;   ///< 0: it is a flag
  std::string description;
  std::string preset;    ///< its default
  std::string variable;  ///< of the environment
  std::string group;     ///< the heading in --help
  bool required = false;
  std::vector<std::string> needs;  ///< names of other options
};

struct Subcommand {
  std::string name, summary;
};

/// A program or one of its commands.
struct CommandEntry {
  std::vector<std::string> path;  ///< {"pointreel-server", "pack", "plan"}
  std::string description;
  std::string usage;  ///< "[OPTIONS] REEL"
  std::string footer;
  std::vector<OptionEntry> options;    ///< those in --help, and the --config that it takes
  std::vector<OptionEntry> arguments;  ///< without dashes, in their order
  std::vector<Subcommand> subcommands;

  /// "pack plan"; empty for the program itself.
  std::string words() const;
};

/// The first line of a description says what the command is for; only its first sentence.
std::string summary_of(const std::string& description);

}  // namespace pointreel::cli
