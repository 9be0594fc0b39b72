#pragma once

#include "pointreel/executor.h"

namespace pointreel {

/// Runs work on the idle threads of the caller's TBB arena. While the caller waits, it does not
/// begin other work of the arena, such as another frame: that would delay the work at hand and keep
/// more frames in memory.
Executor tbb_executor();

}  // namespace pointreel
