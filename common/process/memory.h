#pragma once

#include <malloc.h>

namespace pointreel {

/// To be called at the start of `main` by programs that process frame after frame: makes the
/// allocator keep the memory of one frame for the next. Returning megabytes to the system thirty
/// times a second, only to fault them in again, costs more than building the octree (measured: 3.4
/// instead of 2.3 ms to sort 88,315 points, 17 instead of 8 ms for their mean attributes).
///
/// Blocks of 16 MiB and more go back: of frames that large, the memory of those that are under way
/// would add up (900,000 points: 800 instead of 950 MiB), and their time is hardly noticed.
inline void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 16 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
  mallopt(M_TOP_PAD, 16 << 20);
}

}  // namespace pointreel
