#pragma once

#include <string>
#include <vector>

#include "client/options/play_options.h"
#include "pointreel/error.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace pointreel {

/// The command line of `pointreel play`.
class PlayCommand {
 public:
  /// Adds the subcommand. `app` ends first.
  explicit PlayCommand(CLI::App& app);
  PlayCommand(const PlayCommand&) = delete;
  PlayCommand& operator=(const PlayCommand&) = delete;

  /// After parsing. An error says which options do not go together.
  Result<PlayOptions> options() const;
  /// Adds what the settings file of a window says, where the command line does not; from then on
  /// it is options.settings_file. On an error there is none, and options stay as they are.
  Result<void> read_settings(PlayOptions& options) const;

 private:
  PlayOptions options_;
  // As they are written.
  std::vector<std::string> sources_, places_;
  std::string mode_, instancing_, splatting_, color_, drafts_, background_, up_, size_, view_;
  bool loop_ = true;
  CLI::Option* loop_flag_ = nullptr;
  const CLI::App* command_ = nullptr;
  std::string config_;
  bool no_config_ = false;
};

}  // namespace pointreel
