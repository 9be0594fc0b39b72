#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "codec/octree/context_model.h"
#include "pointreel/octree.h"

/// Trains context tables (codec/octree/context_model.h) on octrees. Masks are chosen greedily: each
/// bit is the one that makes the code of the samples shortest. A table stops growing when
/// describing its alphabets would take more bits than they save (Rissanen, "Modeling by shortest
/// data description", 1978). Sums and logarithms are the same on every machine, so the same trees
/// give the same tables, whatever the number of threads.
namespace pointreel {

struct TrainingOptions {
  int table_bits = 6;           ///< the largest number of bits in a table's mask
  int cell_bits = 4;            ///< the same for the masks of cells
  int part_bits = 5;            ///< the same for the masks of parts of cells
  double alphabet_cost = 50.0;  ///< the number of coded bits that an alphabet must save
  /// Classes whose words tell about masks: more of their bits matter.
  int causal_table_bits = 8;
  double causal_alphabet_cost = 25.0;
};

/// Calls `use(table, word, symbol)` for each symbol that codes the tree's masks. The order is that
/// of the nodes, but not that of the coder within a slice.
void for_each_symbol_of(const Svo& svo,
                        const std::function<void(int table, std::uint64_t word, int symbol)>& use);

/// log2 of a value > 0, computed with additions, multiplications and divisions only, because the
/// last bit of libm's result differs between machines.
double portable_log2(double value);

class ContextTrainer {
 public:
  /// Adds all symbols of the tree.
  void add(const Svo& svo);

  std::size_t sample_count() const;

  struct Result {
    std::array<StoredTable, kTables> tables;  ///< for write_tables
    std::size_t cells = 0, alphabets = 0;
    double bits_per_symbol = 0.0;  ///< for the samples themselves
  };
  Result train(const TrainingOptions& options) const;

 private:
  /// By table: words, with the symbol in the highest four bits.
  std::array<std::vector<std::uint64_t>, kTables> samples_;
};

}  // namespace pointreel
