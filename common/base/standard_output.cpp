#include "common/base/standard_output.h"

#include <cstdio>
#include <iostream>

namespace pointreel {

int finish_output(const char* program, int exit_code) {
  std::cout.flush();
  const bool written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good();
  if (written) return exit_code;
  std::fprintf(stderr, "%s: standard output cannot be written\n", program);
  return exit_code == 0 ? 1 : exit_code;
}

}  // namespace pointreel
