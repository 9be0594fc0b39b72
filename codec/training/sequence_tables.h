#pragma once

#include <cstdint>
#include <span>

#include "pointreel/bytes.h"
#include "pointreel/error.h"
#include "pointreel/octree.h"

/// Context tables for a sequence, trained on some of its frames: the traits that a sensor, a
/// scanner or a mesh leaves in its points are much the same in all of them. A built-in
/// table (context_model.h) is replaced only if this saves more than storing the new one takes.
namespace pointreel {

struct SequenceTables {
  Bytes file;              ///< for read_table_file; empty if the built-in tables are as good
  double saved_bytes = 0;  ///< expected for the whole sequence, minus the size of the file
};

/// `samples`: the trees of some or all of the `frames` frames of a sequence. If they are some (at
/// least two), the tables are trained on three quarters of them and the saving is estimated on the
/// rest. If they are all, the saving is exact up to rounding. Takes about 40 bytes and a
/// microsecond for each node. The same trees give the same tables on any machine and with any
/// number of threads.
Result<SequenceTables> learn_tables(std::span<const Svo> samples, std::uint64_t frames);

}  // namespace pointreel
