#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

namespace pointreel::e2e {

/// What a program printed and how it ended: its exit code, or 128 + the signal that ended it.
struct Outcome {
  int exit_code = -1;
  std::string out, err;
  double peak_mib = 0.0;  ///< resident memory
};

/// Runs one of Pointreel's executables to its end, at most `seconds` long.
Outcome run(const std::string& program, const std::vector<std::string>& arguments,
            int seconds = 120);

/// What a program is started with, beside its arguments.
struct Surroundings {
  std::vector<std::string> environment;  ///< "NAME=VALUE", before the test's own of that name
  std::string err;                       ///< a file for its standard error; empty: the test's
  std::string folder;                    ///< to be in; empty: the test's
};

/// A server in the background, ended with SIGTERM at the latest by the destructor. `program` is one
/// of Pointreel's executables, or any other by its whole path.
class Background {
 public:
  Background(const std::string& program, const std::vector<std::string>& arguments,
             const Surroundings& surroundings = {});
  ~Background();
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  /// The first line that it printed on standard output; empty if it ended without one.
  std::string first_line();

  pid_t pid() const { return pid_; }
  bool running() const;

  /// Sends the signal, 0 for none, and waits; the exit code as in Outcome. A minute later it is
  /// killed.
  int end(int signal);

 private:
  pid_t pid_ = -1;
  int out_ = -1;
};

}  // namespace pointreel::e2e
