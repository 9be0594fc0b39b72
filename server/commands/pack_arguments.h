#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "codec/segments/pack_options.h"
#include "common/command_line/command.h"
#include "pointreel/error.h"
#include "server/commands/sequence_arguments.h"

namespace pointreel {

/// The options of `pack` on a command line.
class PackArguments {
 public:
  /// Adds them to a command, which this object must outlive.
  void add_to(cli::Command command);

  /// What was given, except for the paths without names; an error if some of it does not go
  /// together.
  Result<PackOptions> options() const;
  /// With the paths: an error if there is no input, or if an output is needed and there is none.
  Result<PackOptions> options_with_paths(bool needs_output) const;

  /// What was given, as a command line that stands for the same options, without what is not
  /// about single frames: input, output, --audio and --force. To be called once the command was
  /// parsed.
  std::vector<std::string> command_line() const;

 private:
  PackOptions options_;
  SequenceArguments sequence_;
  cli::Command command_;
  VideoPackOptions video_;
  std::vector<std::filesystem::path> given_paths_;
  cli::Option paths_, input_, output_, force_, audio_, segment_, group_, effort_;
};

/// The options that PackArguments::command_line stands for; without input and output.
Result<PackOptions> parse_pack_command_line(const std::vector<std::string>& arguments);

}  // namespace pointreel
