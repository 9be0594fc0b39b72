#pragma once

#include <new>
#include <stdexcept>

#include "pointreel/error.h"

namespace pointreel {

/// Returns `work()`, a Result, or the error `limit` if there is not enough memory for it. Where
/// this is compiled without exceptions, a lack of memory ends the program instead.
template <class Work>
auto or_out_of_memory(const Work& work) -> decltype(work()) {
#ifdef __cpp_exceptions
  try {
    return work();
  } catch (const std::bad_alloc&) {
  } catch (const std::length_error&) {  // a vector longer than any memory
  }
  // Short enough for a string that allocates nothing.
  return fail(ErrorCode::limit, "out of memory");
#else
  return work();
#endif
}

}  // namespace pointreel
