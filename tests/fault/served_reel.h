#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "tests/e2e/process.h"

namespace pointreel {

/// Packs a ball that turns, eight seconds of it: long enough that no player has all of it soon.
/// Gives the bits a second that playing it takes.
Result<double> make_ball_reel(const std::filesystem::path& folder);

/// pointreel-server in a process of its own.
class ServerProcess {
 public:
  /// `port` 0: any that is free. `options` of pointreel-server serve.
  ServerProcess(const std::filesystem::path& reel, int port = 0,
                const std::vector<std::string>& options = {});
  /// As if the machine had lost its power.
  void kill();
  int port() const { return port_; }  ///< 0 if it did not start
  std::string address() const;        ///< host:port

 private:
  std::unique_ptr<e2e::Background> process_;
  int port_ = 0;
};

}  // namespace pointreel
