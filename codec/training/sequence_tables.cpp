#include "codec/training/sequence_tables.h"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "codec/octree/bit_extract.h"
#include "codec/octree/context_model.h"
#include "codec/octree/context_tables.h"
#include "codec/training/context_trainer.h"
#include "common/base/try.h"
#include "pointreel/package.h"

namespace pointreel {
namespace {

constexpr std::size_t kSlotCount = kLevelClasses * kSlots;
/// The measured size of a leaf in a table file, including its share of the masks, in bits.
constexpr double kStoredLeafBits = 10.0;
/// The number of bits that a leaf must save beyond that. With fewer, tables would fit the samples
/// and no other frame.
constexpr double kLeafMargin = 3.0;

/// The number of bits that decisions take, by slot.
using SlotBits = std::array<double, kSlotCount>;

/// The cost in bits of coding a decision with each probability.
std::vector<float> make_costs() {
  std::vector<float> costs(65537);
  for (int p = 1; p <= 65536; ++p) {
    costs[static_cast<std::size_t>(p)] = static_cast<float>(-portable_log2(p / 65536.0));
  }
  return costs;
}

/// Adds the cost of coding the tree.
void add_cost(const Svo& svo, const ContextTables& tables, const std::vector<float>& costs,
              SlotBits& bits) {
  std::vector<Leaf> leaves = tables.leaves;
  std::vector<ContextLookup<PortableExtract>> lookups;
  for (int c = 0; c < kLevelClasses; ++c) lookups.emplace_back(tables, c, leaves);
  for_each_decision_of(svo, [&](int level_class, int slot, std::uint64_t word, unsigned bit) {
    Leaf& leaf = lookups[static_cast<std::size_t>(level_class)](slot, word);
    const std::uint32_t p = bit != 0 ? leaf.probability : 65536u - leaf.probability;
    bits[static_cast<std::size_t>(level_class * kSlots + slot)] += double{costs[p]};
    adapt(leaf, bit);
  });
}

}  // namespace

Result<SequenceTables> learn_tables(std::span<const Svo> samples, std::uint64_t frames) {
  const bool all = samples.size() >= frames;
  const auto learns = [all](std::size_t i) { return all || i % 4 != 1; };
  const auto judges = [all](std::size_t i) { return all || i % 4 == 1; };
  if (samples.empty() || (!all && samples.size() < 2)) return SequenceTables{};
  const auto built_in = TRY(tables_of_number(kNewestTables));

  ContextTrainer trainer;
  double learnt = 0.0, judged = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!learns(i)) continue;
    trainer.add(samples[i]);
    learnt += 1.0;
  }
  // A leaf is stored once, but saves as much in every frame as it does in the few samples.
  const double total = static_cast<double>(frames);
  TrainingOptions options;
  options.leaf_cost = kLeafMargin + kStoredLeafBits * std::min(1.0, learnt / total);
  ContextTrainer::Result trained = trainer.train(options);
  const auto own = parse_tables(write_tables(trained.slots));
  if (!own) return SequenceTables{};  // they have more leaves than tables may have

  const std::vector<float> costs = make_costs();
  SlotBits built_in_bits{}, own_bits{};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!judges(i)) continue;
    add_cost(samples[i], *built_in, costs, built_in_bits);
    add_cost(samples[i], *own, costs, own_bits);
    judged += 1.0;
  }
  const double scale = total / judged;
  double saved_bits = 0.0;
  for (std::size_t i = 0; i < kSlotCount; ++i) {
    const double saved = (built_in_bits[i] - own_bits[i]) * scale;
    const double stored = kStoredLeafBits * static_cast<double>(trained.slots[i].leaves.size());
    if (saved > stored) {
      saved_bits += saved;
    } else {
      trained.slots[i] = {kBaseSlot, {}, {}};
    }
  }
  SequenceTables result;
  Bytes file = TRY(write_table_file(write_tables(trained.slots)));
  // Each frame names the tables by a checksum of eight bytes.
  result.saved_bytes = saved_bits / 8.0 - static_cast<double>(file.size()) - 8.0 * total;
  if (result.saved_bytes > 0.0 && file.size() <= kMaxTablesBytes) {
    result.file = std::move(file);
  } else {
    result.saved_bytes = 0.0;
  }
  return result;
}

}  // namespace pointreel
