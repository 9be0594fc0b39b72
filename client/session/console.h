#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/playback/stage.h"
#include "common/base/progress.h"
#include "pointreel/error.h"

/// What the player says on standard error while it plays.
namespace pointreel {

/// One line for each broken frame, however often it is tried. From any thread.
class ErrorLines {
 public:
  /// Lines stand above this bar from now on, or no bar if null.
  void set_progress(Progress* progress);
  /// `where`: before the frame's number; empty if there is one source.
  void print(std::size_t source, const std::string& where, std::uint32_t frame, const Error& error);
  /// The last line since this was last asked for.
  std::optional<std::string> take_newest();

 private:
  std::mutex mutex_;
  Progress* progress_ = nullptr;
  std::optional<std::string> newest_;
  std::set<std::pair<std::size_t, std::uint32_t>> printed_;
};

/// One line when something goes wrong with a source, and one when it goes on.
class TroubleLines {
 public:
  /// Lines stand above the bar, if there is one.
  void look(const Stage& stage, Progress* progress = nullptr);
  /// Of the first source that something is wrong with; empty: all is well.
  std::string now() const;

 private:
  std::vector<std::optional<std::string>> said_;
};

}  // namespace pointreel
