#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "codec/octree/context_model.h"
#include "pointreel/octree.h"

/// Makes context tables (codec/octree/context_model.h) from octrees. Masks are chosen greedily, one
/// bit after the other, each the one that makes the code of the samples shortest; a table stops
/// growing where describing its leaves would take more than they save (Rissanen, "Modeling by
/// shortest data description", 1978). Sums and logarithms are the same on every machine, so the
/// same trees give the same tables, whatever the number of threads.
namespace pointreel {

struct TrainingOptions {
  int slot_bits = 11;      ///< most bits of a slot's mask
  int cell_bits = 8;       ///< most bits of a cell's mask
  double leaf_cost = 9.4;  ///< bits that a leaf must save
};

/// Calls `use(level class, slot, neighbourhood word, bit)` for each decision about the tree's
/// nodes, in the order in which they are coded.
void for_each_decision_of(
    const Svo& svo,
    const std::function<void(int level_class, int slot, std::uint64_t word, unsigned bit)>& use);

/// log2 by additions, multiplications and divisions only: libm's last bit differs between machines.
/// value > 0.
double portable_log2(double value);

class ContextTrainer {
 public:
  /// Adds every decision about the tree's nodes.
  void add(const Svo& svo);

  std::size_t sample_count() const;

  struct Result {
    std::array<SlotTables, kLevelClasses * kSlots> slots;  ///< as write_tables takes them
    std::size_t cells = 0, leaves = 0;
    double bits_per_decision = 0.0;  ///< of the samples themselves
  };
  Result train(const TrainingOptions& options) const;

 private:
  /// By class and slot: neighbourhood words, with what was decided as the highest bit.
  std::vector<std::uint64_t> samples_[kLevelClasses][kSlots];
};

}  // namespace pointreel
