#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

namespace pointreel::e2e {

/// The output of a program and its exit code, or 128 + the number of the signal that ended it.
struct Outcome {
  int exit_code = -1;
  std::string out, err;
  double peak_mib = 0.0;  ///< of resident memory
};

/// Runs one of Pointreel's executables until it ends, for at most `seconds`.
Outcome run(const std::string& program, const std::vector<std::string>& arguments,
            int seconds = 120);

/// The conditions under which a program starts, besides its arguments.
struct Surroundings {
  std::vector<std::string> environment;  ///< "NAME=VALUE"; overrides the test's own value
  std::string err;                       ///< a file for standard error; empty: the test's
  std::string folder;                    ///< the working folder; empty: the test's
};

/// A program in the background. The destructor ends it with SIGTERM if it still runs. `program` is
/// one of Pointreel's executables, or any other by its full path.
class Background {
 public:
  Background(const std::string& program, const std::vector<std::string>& arguments,
             const Surroundings& surroundings = {});
  ~Background();
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  /// Returns the first line on standard output, or an empty string if the program ended without
  /// one.
  std::string first_line();

  pid_t pid() const { return pid_; }
  bool running() const;

  /// Sends the signal, or none if it is 0, and waits. Returns the exit code as in Outcome. The
  /// program is killed after a minute.
  int end(int signal);

 private:
  pid_t pid_ = -1;
  int out_ = -1;
};

}  // namespace pointreel::e2e
