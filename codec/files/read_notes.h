#pragma once

#include <string>
#include <vector>

namespace pointreel {

/// What a reader has to say about a file that it could read, in forms that fit into one line.
struct ReadNotes {
  std::vector<std::string> unread;    ///< names of what points have in the file and was skipped
  std::vector<std::string> warnings;  ///< lines without the file's name
  /// The number that stands for full brightness where the type of colours does not tell it: as it
  /// is given to the reader, or 0 to choose it; and then as it was used, or 0 if the type told it.
  double full_color = 0.0;
  bool odd_colors = false;  ///< full brightness is not 1 in floats, or 65535 in integers
};

}  // namespace pointreel
