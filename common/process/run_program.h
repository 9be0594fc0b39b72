#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pointreel/error.h"

namespace pointreel {

struct ProgramOutcome {
  int exit_code = 0;  ///< 128 plus the signal if one ended it
  std::string out;    ///< standard output and errors together, at most the first 64 KiB
};

/// Runs a program of the PATH with these arguments, the name first, and waits for its end. Its
/// standard input is empty. The error (`not_found`) says that the program is missing.
Result<ProgramOutcome> run_program(const std::vector<std::string>& arguments);

/// A text as one word for a shell: in quotes where it needs them.
std::string shell_word(std::string_view text);

}  // namespace pointreel
