#pragma once

namespace pointreel {

/// To be called at the end of a program: hands everything that was printed to the system. Returns
/// the exit code: `exit_code`, or 1 instead of 0 if standard output could not be written, which is
/// reported as `PROGRAM: ...`.
int finish_output(const char* program, int exit_code);

}  // namespace pointreel
