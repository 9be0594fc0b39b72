#include "common/process/standard_output.h"

#include <cstdio>
#include <iostream>

#include "common/process/print.h"

namespace pointreel {

int finish_output(const char* program, int exit_code) {
  std::cout.flush();  // CLI11 prints help on it
  const bool written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good();
  if (written) return exit_code;
  print_error(program, "standard output cannot be written");
  return exit_code == 0 ? 1 : exit_code;
}

}  // namespace pointreel
