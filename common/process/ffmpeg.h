#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pointreel/error.h"

namespace pointreel {

/// Whether a program can be run: one on the path, or a file if the name has a '/'.
bool is_installed(const std::string& program);

/// ffmpeg as a child process, in a process group of its own, so that a Ctrl+C for this program does
/// not cut off what it writes.
class Ffmpeg {
 public:
  /// What it reads and writes: open files, which stay the caller's; -1: nothing.
  struct Files {
    int input = -1;         ///< its pipe:0
    int output = -1;        ///< its pipe:1
    int second_input = -1;  ///< its pipe:3
  };
  /// Starts it, or ffprobe, with these arguments. Errors: `not_found` if the program is not
  /// installed; `io`.
  static Result<Ffmpeg> start(const std::vector<std::string>& arguments, const Files& files,
                              const std::string& program = "ffmpeg");

  Ffmpeg(Ffmpeg&& other) noexcept;
  Ffmpeg& operator=(Ffmpeg&&) = delete;
  /// Kills it, unless it has been waited for.
  ~Ffmpeg();

  void kill() const;
  /// Waits until it has ended, and says whether all went well. Closing its input, or what it writes
  /// to, is up to the caller. May be asked again.
  bool wait();
  /// The first 4096 bytes that it has written to its standard error, where it says what goes wrong.
  std::string said() const;
  /// Why it ended, once it has been waited for: the first line that it said, or the signal; empty
  /// if there is neither. The text is one line, and may hold anything else from the file.
  std::string reason() const;

 private:
  Ffmpeg(int process, int messages) : process_(process), messages_(messages) {}

  int process_ = -1;   ///< -1 after it has ended
  int messages_ = -1;  ///< a nameless file for its standard error
  int status_ = 0;     ///< of waitpid
};

}  // namespace pointreel
