#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "tests/e2e/process.h"

namespace pointreel {

/// Packs eight seconds of a turning ball: so long that no player has all of it soon. Returns the
/// bits per second that are needed to play it.
Result<double> make_ball_reel(const std::filesystem::path& folder);

/// pointreel-server in a process of its own.
class ServerProcess {
 public:
  /// Starts on any free port if `port` is 0. `options` are those of pointreel-server serve.
  ServerProcess(const std::filesystem::path& reel, int port = 0,
                const std::vector<std::string>& options = {});
  /// Ends the server as a power failure would.
  void kill();
  int port() const { return port_; }  ///< 0 if it did not start
  std::string address() const;        ///< host:port

 private:
  std::unique_ptr<e2e::Background> process_;
  int port_ = 0;
};

}  // namespace pointreel
