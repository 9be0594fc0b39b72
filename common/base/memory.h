#pragma once

#include <malloc.h>

namespace pointreel {

/// For the start of `main` in programs that handle frame after frame: makes the allocator keep the
/// memory of one frame for the next. Giving megabytes back to the system thirty times a second and
/// faulting them in again costs more than building the octree does (measured: 3.4 against 2.3 ms to
/// sort 88,315 points, 17 against 8 ms for their mean attributes).
inline void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 256 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
  mallopt(M_TOP_PAD, 16 << 20);
}

}  // namespace pointreel
