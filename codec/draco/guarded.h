#pragma once

#include <exception>
#include <new>
#include <string>

#include "common/base/concat.h"
#include "pointreel/error.h"

namespace pointreel {

/// Returns `work()`, a Result, or an error if it throws: `no_memory`, or `failed` with Draco's own
/// words behind it. Where this is compiled without exceptions, that ends the program instead.
template <class Work>
auto guarded(const char* no_memory, const char* failed, const Work& work) -> decltype(work()) {
#ifdef __cpp_exceptions
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::limit, no_memory);
  } catch (const std::exception& error) {
    return fail(concat(failed, " (", error.what(), ")"));
  }
#else
  static_cast<void>(no_memory);
  static_cast<void>(failed);
  return work();
#endif
}

}  // namespace pointreel
