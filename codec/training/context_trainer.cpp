#include "codec/training/context_trainer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>

#include <tbb/parallel_for.h>

#include "codec/octree/raster_walk.h"

namespace pointreel {
namespace {

using Samples = std::span<std::uint64_t>;
constexpr int kOutcome = 63;

/// Tables of n log2 n and of log2(n + 1) / 2.
class Logarithms {
 public:
  Logarithms() {
    for (std::size_t n = 1; n < kTabled; ++n) {
      n_log_n_[n] = static_cast<double>(n) * portable_log2(static_cast<double>(n));
      half_log_[n] = 0.5 * portable_log2(static_cast<double>(n + 1));
    }
  }
  double n_log_n(std::uint32_t n) const { return n < kTabled ? n_log_n_[n] : n * portable_log2(n); }
  double half_log(std::uint32_t n) const {
    return n < kTabled ? half_log_[n] : 0.5 * portable_log2(n + 1.0);
  }

 private:
  static constexpr std::size_t kTabled = 1u << 14;
  std::vector<double> n_log_n_ = std::vector<double>(kTabled);
  std::vector<double> half_log_ = std::vector<double>(kTabled);
};

/// The number of ones, and of all decisions, that share a context.
struct Counts {
  std::uint32_t ones = 0, all = 0;
};

/// How often each bit of the word is set among the decisions with each outcome.
struct BitCounts {
  std::array<std::array<std::uint32_t, 64>, 2> set{};  ///< by outcome
  std::array<std::uint32_t, 2> total{};
};

/// For each byte, eight bytes with one of its bits each.
std::array<std::uint64_t, 256> make_spread() {
  std::array<std::uint64_t, 256> spread{};
  for (std::size_t byte = 0; byte < 256; ++byte) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      spread[byte] |= std::uint64_t{byte >> bit & 1u} << (8 * bit);
    }
  }
  return spread;
}

void count_bits(std::span<const std::uint64_t> samples, BitCounts& counts) {
  static const auto spread = make_spread();
  std::array<std::array<std::uint64_t, 8>, 2> sums{};
  std::array<unsigned, 2> pending{};
  const auto flush = [&](std::size_t outcome) {
    for (std::size_t i = 0; i < 64; ++i) {
      counts.set[outcome][i] +=
          static_cast<std::uint32_t>(sums[outcome][i / 8] >> (8 * (i % 8)) & 255u);
    }
    sums[outcome] = {};
    counts.total[outcome] += pending[outcome];
    pending[outcome] = 0;
  };
  for (const std::uint64_t word : samples) {
    const std::size_t outcome = word >> kOutcome;
    for (std::size_t i = 0; i < 8; ++i) sums[outcome][i] += spread[word >> (8 * i) & 255u];
    if (++pending[outcome] == 255) flush(outcome);
  }
  flush(0);
  flush(1);
}

class GreedyMask {
 public:
  GreedyMask(const Logarithms& logs, double leaf_cost) : logs_(logs), leaf_cost_(leaf_cost) {}

  /// The number of bits for coding a leaf's decisions adaptively, and for describing the leaf.
  double cost(std::uint32_t ones, std::uint32_t all) const {
    if (all == 0) return 0.25 * leaf_cost_;
    return logs_.n_log_n(all) - logs_.n_log_n(ones) - logs_.n_log_n(all - ones) +
           logs_.half_log(all) + leaf_cost_;
  }

  /// The best mask with at most `most_bits` of the `allowed` bits. Reorders the samples.
  std::uint64_t choose(Samples samples, std::uint64_t allowed, int most_bits) const {
    std::vector<Samples> groups{samples};
    std::uint64_t mask = 0, best_mask = 0;
    double best = -1.0;
    int since_best = 0;
    std::vector<double> candidates(64);
    for (int bits = 0; bits <= most_bits; ++bits) {
      std::fill(candidates.begin(), candidates.end(), 0.0);
      double now = 0.0;
      for (const Samples group : groups) {
        BitCounts counts;
        count_bits(group, counts);
        const std::uint32_t ones = counts.total[1], all = ones + counts.total[0];
        now += cost(ones, all);
        if (bits == most_bits) continue;
        for (std::uint64_t rest = allowed; rest != 0; rest &= rest - 1) {
          const auto f = static_cast<std::size_t>(std::countr_zero(rest));
          const std::uint32_t set_ones = counts.set[1][f], set = set_ones + counts.set[0][f];
          candidates[f] += cost(set_ones, set) + cost(ones - set_ones, all - set);
        }
      }
      if (best < 0.0 || now < best) {
        best = now;
        best_mask = mask;
        since_best = 0;
      } else if (++since_best > 2) {
        break;
      }
      if (bits == most_bits || allowed == 0) break;
      std::size_t chosen = 64;
      for (std::uint64_t rest = allowed; rest != 0; rest &= rest - 1) {
        const auto f = static_cast<std::size_t>(std::countr_zero(rest));
        if (chosen == 64 || candidates[f] < candidates[chosen]) chosen = f;
      }
      const std::uint64_t bit = std::uint64_t{1} << chosen;
      mask |= bit;
      allowed &= ~bit;
      std::vector<Samples> halves;
      for (const Samples group : groups) {
        const auto middle = std::partition(group.begin(), group.end(),
                                           [bit](std::uint64_t word) { return (word & bit) == 0; });
        const auto zeros = static_cast<std::size_t>(middle - group.begin());
        halves.push_back(group.first(zeros));
        halves.push_back(group.subspan(zeros));
      }
      groups.swap(halves);
    }
    return best_mask;
  }

 private:
  const Logarithms& logs_;
  double leaf_cost_;
};

std::uint64_t gather(std::uint64_t word, std::uint64_t mask) {
  std::uint64_t bits = 0;
  for (unsigned i = 0; mask != 0; ++i, mask &= mask - 1) {
    bits |= (word >> std::countr_zero(mask) & 1u) << i;
  }
  return bits;
}

/// The bits that a slot's decisions may depend on: all but those of children that are coded later.
std::uint64_t allowed_bits(int slot) {
  std::uint64_t allowed = (std::uint64_t{1} << neighborhood::kBits) - 1;
  const int known = slot < kOnlyChildSlot ? slot : 0;
  for (int child = known; child < 7; ++child) {
    allowed &= ~(std::uint64_t{1} << (neighborhood::kOwn + child));
  }
  return allowed;
}

struct TrainedSlot {
  SlotTables tables;
  double bits = 0.0;
};

TrainedSlot train_slot(std::vector<std::uint64_t> samples, int slot, const TrainingOptions& options,
                       const Logarithms& logs) {
  TrainedSlot trained;
  const GreedyMask greedy(logs, options.leaf_cost);
  const std::uint64_t allowed = allowed_bits(slot);
  trained.tables.mask = greedy.choose(samples, allowed, options.slot_bits);
  std::vector<std::vector<std::uint64_t>> cells(std::size_t{1}
                                                << std::popcount(trained.tables.mask));
  double ones = 1.0;
  for (const std::uint64_t word : samples) {
    cells[gather(word, trained.tables.mask)].push_back(word);
    ones += static_cast<double>(word >> kOutcome);
  }
  const double share = ones / (static_cast<double>(samples.size()) + 2.0);
  for (std::vector<std::uint64_t>& cell : cells) {
    const std::uint64_t mask =
        greedy.choose(cell, allowed & ~trained.tables.mask, options.cell_bits);
    trained.tables.cells.push_back(mask);
    std::vector<Counts> leaves(std::size_t{1} << std::popcount(mask));
    Counts whole;
    for (const std::uint64_t word : cell) {
      Counts& leaf = leaves[gather(word, mask)];
      for (Counts* counts : {&leaf, &whole}) {
        ++counts->all;
        counts->ones += static_cast<std::uint32_t>(word >> kOutcome);
      }
    }
    // A leaf with few samples is drawn towards its cell, and a cell with few towards its slot.
    const double cell_share = (whole.ones + 2.0 * share) / (whole.all + 2.0);
    for (const Counts& leaf : leaves) {
      const double probability = (leaf.ones + cell_share) / (leaf.all + 1.0);
      trained.tables.leaves.push_back(pack_leaf(probability, leaf.all));
      trained.bits +=
          logs.n_log_n(leaf.all) - logs.n_log_n(leaf.ones) - logs.n_log_n(leaf.all - leaf.ones);
    }
  }
  return trained;
}

}  // namespace

double portable_log2(double value) {
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);  // 0.5 to 1
  const double t = (mantissa - 0.70710678118654752) / (mantissa + 0.70710678118654752);
  double power = t, sum = 0.0;
  for (int n = 1; n <= 21; n += 2, power *= t * t) sum += power / n;
  return 2.8853900817779268 * sum + exponent - 0.5;
}

void for_each_decision_of(
    const Svo& svo,
    const std::function<void(int level_class, int slot, std::uint64_t word, unsigned bit)>& use) {
  if (svo.node_count() == 0) return;
  RasterLevel level = root_level();
  for (int number = 0; number < svo.depth; ++number) {
    const std::size_t begin = svo.level_begin[static_cast<std::size_t>(number)];
    for (std::size_t i = 0; i < level.size(); ++i) {
      level.masks[i] = svo.masks[begin + level.rank[i]];
    }
    const std::size_t children = svo.node_count(number + 1);
    const int level_class = pointreel::level_class(level.size(), children);
    const bool sparse = codes_only_child(level_class);
    LevelWalk(level).visit(kAllNodes, [&](std::uint32_t node, std::uint64_t word) -> std::uint32_t {
      if (sparse) word = neighborhood::sparse_word(word, level.parents[node]);
      for_each_decision(sparse, word, level.masks[node],
                        [&](int slot, std::uint64_t context, unsigned bit) {
                          use(level_class, slot, context, bit);
                        });
      return level.masks[node];
    });
    std::vector<std::uint32_t> first_child(level.size());
    for (std::size_t i = 0; i < level.size(); ++i) {
      first_child[i] =
          svo.first_child[begin + i] - svo.level_begin[static_cast<std::size_t>(number) + 1];
    }
    RasterLevel below;
    expand(level, first_child, children, below);
    level = std::move(below);
  }
}

void ContextTrainer::add(const Svo& svo) {
  for_each_decision_of(svo, [this](int level_class, int slot, std::uint64_t word, unsigned bit) {
    samples_[level_class][slot].push_back(word | std::uint64_t{bit} << kOutcome);
  });
}

std::size_t ContextTrainer::sample_count() const {
  std::size_t count = 0;
  for (const auto& slots : samples_) {
    for (const auto& samples : slots) count += samples.size();
  }
  return count;
}

ContextTrainer::Result ContextTrainer::train(const TrainingOptions& options) const {
  const Logarithms logs;
  std::vector<TrainedSlot> trained(kLevelClasses * kSlots);
  tbb::parallel_for(std::size_t{0}, trained.size(), [&](std::size_t i) {
    const int slot = static_cast<int>(i % kSlots);
    trained[i] = train_slot(samples_[i / kSlots][slot], slot, options, logs);
  });
  Result result;
  double bits = 0.0;
  for (std::size_t i = 0; i < trained.size(); ++i) {
    result.cells += trained[i].tables.cells.size();
    result.leaves += trained[i].tables.leaves.size();
    bits += trained[i].bits;
    result.slots[i] = std::move(trained[i].tables);
  }
  result.bits_per_decision = bits / static_cast<double>(std::max<std::size_t>(1, sample_count()));
  return result;
}

}  // namespace pointreel
