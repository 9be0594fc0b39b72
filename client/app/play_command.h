#pragma once

#include <string>
#include <utility>
#include <vector>

#include "client/options/option_table.h"
#include "client/options/play_options.h"
#include "common/command_line/command.h"
#include "pointreel/error.h"

namespace pointreel {

/// The command line of `pointreel play`.
class PlayCommand {
 public:
  /// Adds the subcommand to `app`, which must be destroyed first.
  explicit PlayCommand(cli::Command app);
  PlayCommand(const PlayCommand&) = delete;
  PlayCommand& operator=(const PlayCommand&) = delete;

  /// To be called after parsing. The error says which options do not go together.
  Result<PlayOptions> options() const;
  /// Takes the settings that the command line does not give from the settings file, which becomes
  /// options.settings_file. On an error there is none, and the other options stay as they are.
  Result<void> read_settings(PlayOptions& options) const;

 private:
  void add_sources(cli::Command command);
  void add_settings(cli::Command command);
  void add_playback(cli::Command command);
  void add_window(cli::Command command);
  void add_output(cli::Command command);
  Result<void> set_given(Settings& settings) const;

  cli::Command command_;
  cli::Option token_;
  std::vector<std::pair<const Option*, cli::Option>> given_;  ///< options of the table
  PlayOptions options_;
  // As they are written on the command line.
  std::vector<std::string> sources_, positions_;
  std::string environment_;  ///< a file
  std::string color_range_;
  std::string up_, offscreen_, camera_, target_, config_, token_file_;
  bool no_config_ = false;
};

}  // namespace pointreel
