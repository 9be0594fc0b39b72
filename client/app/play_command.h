#pragma once

#include <string>
#include <vector>

#include "client/options/play_options.h"
#include "pointreel/error.h"

namespace CLI {
class App;
}  // namespace CLI

namespace pointreel {

/// The command line of `pointreel play`.
class PlayCommand {
 public:
  /// Adds the subcommand to `app`, which must be destroyed first.
  explicit PlayCommand(CLI::App& app);
  PlayCommand(const PlayCommand&) = delete;
  PlayCommand& operator=(const PlayCommand&) = delete;

  /// To be called after parsing. The error says which options do not go together.
  Result<PlayOptions> options() const;
  /// Takes the settings that the command line does not give from the settings file, which becomes
  /// options.settings_file. On an error there is none, and the other options stay as they are.
  Result<void> read_settings(PlayOptions& options) const;

 private:
  void add_sources(CLI::App& command);
  void add_settings(CLI::App& command);
  void add_playback(CLI::App& command);
  void add_window(CLI::App& command);
  void add_output(CLI::App& command);
  Result<void> set_given(Settings& settings) const;

  const CLI::App* command_ = nullptr;
  PlayOptions options_;
  // As they are written on the command line.
  std::vector<std::string> sources_, positions_;
  std::string environment_;  ///< a file
  std::string color_range_;
  std::string up_, offscreen_, camera_, config_;
  bool no_config_ = false;
};

}  // namespace pointreel
