#pragma once

#include "pointreel/executor.h"

namespace pointreel {

/// Lends the threads of the caller's TBB arena, as far as they have nothing else to do. While the
/// caller waits for them it begins no other work of the arena, such as another frame: what it does
/// takes no longer than alone, and no more frames are in memory than there would be otherwise.
Executor tbb_executor();

}  // namespace pointreel
