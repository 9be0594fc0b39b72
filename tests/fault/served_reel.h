#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/e2e/process.h"
#include "tests/fault/watcher.h"
#include "tests/temporary_folder.h"

namespace pointreel {

/// A reel long enough that no player has all of it soon, and its truth.
class FaultReel {
 public:
  static const FaultReel& get();  ///< made once for all tests
  std::string path() const { return (folder_ / "ball").string(); }
  const Truth& truth() const { return truth_; }
  double bits_per_second() const { return bits_per_second_; }

 private:
  FaultReel();
  TemporaryFolder folder_;
  Truth truth_;
  double bits_per_second_ = 0.0;
};

/// pointreel-server in a process of its own.
class ServerProcess {
 public:
  /// `port` 0: any that is free. `options` of pointreel-server serve.
  explicit ServerProcess(int port = 0, const std::vector<std::string>& options = {});
  /// As if the machine had lost its power.
  void kill();
  int port() const { return port_; }
  std::string address() const;  ///< host:port

 private:
  std::unique_ptr<e2e::Background> process_;
  int port_ = 0;
};

}  // namespace pointreel
