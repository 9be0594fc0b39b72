#pragma once

#include <exception>
#include <new>

#include "common/process/memory.h"
#include "common/process/print.h"
#include "common/process/standard_output.h"

namespace pointreel {

/// What main returns: the exit code that `run()` returns, or 1, after a line, if it throws or
/// standard output fails. `no_memory` is that line where memory is short.
template <class Run>
int run_main(const char* name, const Run& run, const char* no_memory = "not enough memory") {
  keep_freed_memory();
  int exit_code = 1;
  try {
    exit_code = run();
  } catch (const std::bad_alloc&) {
    print_error(name, no_memory);
  } catch (const std::exception& error) {
    print_error(name, error.what());
  }
  return finish_output(name, exit_code);
}

}  // namespace pointreel
