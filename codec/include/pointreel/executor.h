#pragma once

#include <functional>

namespace pointreel {

/// Calls body(0) to body(count - 1), in any order and possibly in parallel, and returns when all of
/// the calls have returned. The codec starts no threads; it lets an executor spread its work over
/// the caller's. An empty function stands for no executor: the work is then done in the calling
/// thread. Results never depend on the executor.
using Executor = std::function<void(int count, const std::function<void(int)>& body)>;

}  // namespace pointreel
