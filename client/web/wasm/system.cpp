#include <cstddef>

#include <wasi/api.h>

#include "common/threads/tbb_executor.h"

// What the C and C++ libraries and our own would otherwise ask the system for. With it the module
// imports nothing.

extern "C" {

[[gnu::used]] void abort() { __builtin_trap(); }

/// The libraries' last words, for which there is no output. What the page sees is the trap.
[[noreturn]] void abort_message(const char*, ...) { __builtin_trap(); }

/// Nothing ever ends, so that nothing is destroyed.
int __cxa_atexit(void (*)(void*), void*, void*) { return 0; }

/// The JSON library writes a text about what it could not read with this, which nobody reads.
int snprintf(char* text, std::size_t size, const char*, ...) {
  if (size > 0) *text = '\0';
  return 0;
}

// In place of the functions behind __wrap_ (CMakeLists.txt). There are no files; Draco would print
// words for its developers.
__wasi_errno_t __wrap___wasi_fd_close(__wasi_fd_t) { return __WASI_ERRNO_BADF; }
__wasi_errno_t __wrap___wasi_fd_fdstat_get(__wasi_fd_t, __wasi_fdstat_t*) {
  return __WASI_ERRNO_BADF;
}
__wasi_errno_t __wrap___wasi_fd_seek(__wasi_fd_t, __wasi_filedelta_t, __wasi_whence_t,
                                     __wasi_filesize_t*) {
  return __WASI_ERRNO_BADF;
}
__wasi_errno_t __wrap___wasi_fd_write(__wasi_fd_t, const __wasi_ciovec_t*, size_t, __wasi_size_t*) {
  return __WASI_ERRNO_BADF;
}

/// The page measures time. Durations that are measured inside are 0.
__wasi_errno_t __wrap___wasi_clock_time_get(__wasi_clockid_t, __wasi_timestamp_t,
                                            __wasi_timestamp_t* time) {
  *time = 0;
  return __WASI_ERRNO_SUCCESS;
}
}

namespace std {
inline namespace __2 {
[[noreturn]] void __libcpp_verbose_abort(const char*, ...) { __builtin_trap(); }
}  // namespace __2
}  // namespace std

namespace pointreel {

/// There are no threads: everything is done in turn.
Executor tbb_executor() { return {}; }

}  // namespace pointreel
