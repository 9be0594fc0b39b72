#pragma once

#include <string>
#include <vector>

namespace pointreel {

/// What a reader has to say about a file that it could read, in forms that fit into one line.
struct ReadNotes {
  std::vector<std::string> unread;    ///< names of what points have in the file and was skipped
  std::vector<std::string> warnings;  ///< lines without the file's name
};

}  // namespace pointreel
