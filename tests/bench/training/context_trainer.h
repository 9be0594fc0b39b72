#pragma once

#include <cstdint>
#include <vector>

#include "codec/octree/context_model.h"
#include "common/base/bytes.h"
#include "common/octree/svo.h"

/// Makes context tables (codec/octree/context_model.h) from octrees. Masks are chosen greedily, one
/// bit after the other, each the one that makes the code of the samples shortest; a table stops
/// growing where describing its leaves would take more than they save (Rissanen, "Modeling by
/// shortest data description", 1978). Sums and logarithms are the same on every machine, so the
/// same trees give the same tables, whatever the number of threads.
namespace pointreel::bench {

struct TrainingOptions {
  int slot_bits = 11;      ///< most bits of a slot's mask
  int cell_bits = 8;       ///< most bits of a cell's mask
  double leaf_cost = 8.0;  ///< bits that a leaf must save
};

class ContextTrainer {
 public:
  /// Adds every decision about the tree's nodes.
  void add(const Svo& svo);

  std::size_t sample_count() const;

  struct Result {
    Bytes tables;  ///< as parse_tables reads them
    std::size_t cells = 0, leaves = 0;
    double bits_per_decision = 0.0;  ///< of the samples themselves
  };
  Result train(const TrainingOptions& options) const;

 private:
  /// By class and slot: neighbourhood words, with what was decided as the highest bit.
  std::vector<std::uint64_t> samples_[kLevelClasses][kSlots];
};

}  // namespace pointreel::bench
