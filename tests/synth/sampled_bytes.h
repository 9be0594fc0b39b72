#pragma once

#include <tbb/task_arena.h>

#include "codec/files/ply.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/sequences.h"

namespace pointreel {

/// A PLY file of the eleventh frame of "walk", sampled with so many threads.
inline Bytes sampled_bytes(const SequenceOptions& options, int threads) {
  tbb::task_arena arena(threads);
  return arena.execute(
      [&] { return ply_bytes(sequence_frame(*find_motion("walk"), options, 11).value()); });
}

}  // namespace pointreel
