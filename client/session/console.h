#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/playback/stage.h"
#include "common/process/progress.h"
#include "pointreel/error.h"

/// What the player prints on standard error while it plays.
namespace pointreel {

/// Prints one line for each broken frame, and for broken sound, however often it is tried again. If
/// many frames fail in the same way, only the first is named. Any thread may call it.
class ErrorLines {
 public:
  /// From now on lines are printed above this bar; null: there is none.
  void set_progress(Progress* progress);
  /// `where` precedes the frame's number; it is empty if there is only one source.
  /// Without a frame, the error is of the sound.
  void print(std::size_t source, const std::string& where, std::optional<std::uint32_t> frame,
             const Error& error);
  /// The last line that was printed since the previous call, if any.
  std::optional<std::string> take_newest();

 private:
  std::mutex mutex_;
  Progress* progress_ = nullptr;
  std::optional<std::string> newest_;
  std::set<std::pair<std::size_t, std::optional<std::uint32_t>>> printed_;
  std::map<std::pair<std::size_t, std::string>, int> times_;  ///< each message of a source
};

/// Prints a line when a source gets into trouble, such as a lost connection, and another when it
/// recovers.
class TroubleLines {
 public:
  /// To be called now and then. Lines are printed above the bar, if there is one.
  void look(const Stage& stage, Progress* progress = nullptr);
  /// The trouble of the first source that has any; empty: all is well.
  std::string now() const;

 private:
  std::vector<std::optional<std::string>> troubles_;  ///< of each source
};

}  // namespace pointreel
