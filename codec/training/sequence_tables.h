#pragma once

#include <cstdint>
#include <span>

#include "pointreel/bytes.h"
#include "pointreel/error.h"
#include "pointreel/octree.h"

/// Context tables of a sequence's own, learnt from some of its frames: what a sensor, a scanner or
/// a mesh does to its points is much the same in all of them. A slot of the tables
/// (context_model.h) is replaced only where that saves more than it takes to store it.
namespace pointreel {

struct SequenceTables {
  Bytes file;              ///< as read_table_file reads it; empty if the built-in tables do as well
  double saved_bytes = 0;  ///< expected of the whole sequence, the file's own bytes taken off
};

/// `samples`: trees of some of the `frames` frames of a sequence, or of all. Where they are some, a
/// quarter of them (two or more are needed) tells what the others' tables are worth, and the saving
/// is an estimate; where they are all, it is what coding them takes but for rounding. Takes about
/// 40 bytes and a microsecond for each node. The same for the same trees, on any machine and with
/// any number of threads.
Result<SequenceTables> learn_tables(std::span<const Svo> samples, std::uint64_t frames);

}  // namespace pointreel
