#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "codec/octree/context_model.h"
#include "pointreel/octree.h"

/// Trains context tables (codec/octree/context_model.h) on octrees. Masks are chosen greedily: each
/// bit is the one that makes the code of the samples shortest. A table stops growing when
/// describing its leaves would take more bits than they save (Rissanen, "Modeling by shortest data
/// description", 1978). Sums and logarithms are the same on every machine, so the same trees give
/// the same tables, whatever the number of threads.
namespace pointreel {

struct TrainingOptions {
  int slot_bits = 11;      ///< the largest number of bits in a slot's mask
  int cell_bits = 8;       ///< the largest number of bits in a cell's mask
  double leaf_cost = 9.4;  ///< the number of coded bits that a leaf must save
};

/// Calls `use(level class, slot, neighbourhood word, bit)` for each decision about the tree's
/// nodes, in the order in which they are coded.
void for_each_decision_of(
    const Svo& svo,
    const std::function<void(int level_class, int slot, std::uint64_t word, unsigned bit)>& use);

/// log2 of a value > 0, computed with additions, multiplications and divisions only, because the
/// last bit of libm's result differs between machines.
double portable_log2(double value);

class ContextTrainer {
 public:
  /// Adds all decisions about the tree's nodes.
  void add(const Svo& svo);

  std::size_t sample_count() const;

  struct Result {
    std::array<SlotTables, kLevelClasses * kSlots> slots;  ///< for write_tables
    std::size_t cells = 0, leaves = 0;
    double bits_per_decision = 0.0;  ///< for the samples themselves
  };
  Result train(const TrainingOptions& options) const;

 private:
  /// By class and slot: neighbourhood words, with the decision as the highest bit.
  std::vector<std::uint64_t> samples_[kLevelClasses][kSlots];
};

}  // namespace pointreel
