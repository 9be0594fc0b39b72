#include "codec/training/context_trainer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>

#include <tbb/parallel_for.h>

#include "codec/octree/causal_walk.h"
#include "codec/octree/orientation.h"
#include "codec/octree/slice_level.h"
#include "codec/octree/sparse_words.h"

namespace pointreel {
namespace {

using Samples = std::span<std::uint64_t>;
constexpr int kSymbol = 60;
constexpr std::size_t kSymbols = 16;
static_assert(causal_word::kBits <= kSymbol && sparse_word::kBits <= kSymbol);

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

/// How often each symbol occurs.
using Counts = std::array<std::uint32_t, kSymbols>;

std::uint32_t sum(const Counts& counts) {
  std::uint32_t sum = 0;
  for (const std::uint32_t count : counts) sum += count;
  return sum;
}

Counts operator-(const Counts& a, const Counts& b) {
  Counts difference;
  for (std::size_t i = 0; i < kSymbols; ++i) difference[i] = a[i] - b[i];
  return difference;
}

/// The symbols of all samples, and of those in whose word each bit is set.
struct BitCounts {
  std::array<Counts, kSymbol> set{};
  Counts all{};
};

/// Counts at most about kMostCounted samples, which are enough to tell one bit from another.
/// Returns for how many samples each of them stands.
std::size_t count_bits(std::span<const std::uint64_t> samples, std::uint64_t allowed,
                       BitCounts& counts) {
  constexpr std::size_t kMostCounted = std::size_t{1} << 17;
  const std::size_t step = samples.size() / kMostCounted + 1;
  for (std::size_t i = 0; i < samples.size(); i += step) {
    const auto symbol = static_cast<std::size_t>(samples[i] >> kSymbol);
    ++counts.all[symbol];
    for (std::uint64_t rest = samples[i] & allowed; rest != 0; rest &= rest - 1) {
      ++counts.set[static_cast<std::size_t>(std::countr_zero(rest))][symbol];
    }
  }
  return step;
}

class GreedyMask {
 public:
  GreedyMask(const Logarithms& logs, double alphabet_cost)
      : logs_(logs), alphabet_cost_(alphabet_cost) {}

  /// The number of bits for coding the symbols.
  double bits(const Counts& counts) const {
    double bits = logs_.n_log_n(sum(counts));
    for (const std::uint32_t count : counts) bits -= logs_.n_log_n(count);
    return bits;
  }

  /// The number of bits for coding the symbols adaptively and for describing the alphabet, if each
  /// stands for `step` symbols.
  double cost(const Counts& counts, std::size_t step) const {
    const std::uint32_t all = sum(counts);
    if (all == 0) return 0.25 * alphabet_cost_;
    std::size_t kinds = 0;
    for (const std::uint32_t count : counts) kinds += count > 0 ? 1 : 0;
    return static_cast<double>(step) * bits(counts) +
           static_cast<double>(kinds - 1) * logs_.half_log(all) + alphabet_cost_;
  }

  /// The best mask with at most `most_bits` of the `allowed` bits. Reorders the samples.
  std::uint64_t choose(Samples samples, std::uint64_t allowed, int most_bits) const {
    std::vector<Samples> groups{samples};
    std::uint64_t mask = 0, best_mask = 0;
    double best = -1.0;
    int since_best = 0;
    std::array<double, kSymbol> candidates;
    for (int bits = 0; bits <= most_bits; ++bits) {
      candidates.fill(0.0);
      double now = 0.0;
      for (const Samples group : groups) {
        BitCounts counts;
        const std::size_t step = count_bits(group, bits == most_bits ? 0 : allowed, counts);
        const double whole = cost(counts.all, step);
        now += whole;
        if (bits == most_bits) continue;
        for (std::uint64_t rest = allowed; rest != 0; rest &= rest - 1) {
          const auto f = static_cast<std::size_t>(std::countr_zero(rest));
          const std::uint32_t set = sum(counts.set[f]);
          const bool divides = set != 0 && set != sum(counts.all);
          candidates[f] += divides
                               ? cost(counts.set[f], step) + cost(counts.all - counts.set[f], step)
                               : whole + 0.25 * alphabet_cost_;
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
      std::size_t chosen = kSymbol;
      for (std::uint64_t rest = allowed; rest != 0; rest &= rest - 1) {
        const auto f = static_cast<std::size_t>(std::countr_zero(rest));
        if (chosen == kSymbol || candidates[f] < candidates[chosen]) chosen = f;
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
  double alphabet_cost_;
};

std::uint64_t gather(std::uint64_t word, std::uint64_t mask) {
  std::uint64_t bits = 0;
  for (unsigned i = 0; mask != 0; ++i, mask &= mask - 1) {
    bits |= (word >> std::countr_zero(mask) & 1u) << i;
  }
  return bits;
}

/// The bits that a table's symbols may depend on: the lower half is known only to the upper one.
std::uint64_t allowed_bits(int table) {
  const bool causal = is_causal_table(table);
  const std::uint64_t low = std::uint64_t{15}
                            << (causal ? causal_word::kLowHalf : sparse_word::kLowHalf);
  const std::uint64_t all =
      (std::uint64_t{1} << (causal ? causal_word::kBits : sparse_word::kBits)) - 1;
  for (int c = 0; c < kLevelClasses; ++c) {
    if (table == table_of(c, SymbolKind::high_half)) return all;
  }
  return all & ~low;
}

using Shares = std::array<double, kSymbols>;

/// The shares of the symbols, drawn towards others that count as much as `weight` symbols.
Shares shares_of(const Counts& counts, const Shares& towards, double weight) {
  Shares shares;
  const double all = sum(counts) + weight;
  for (std::size_t i = 0; i < kSymbols; ++i) shares[i] = (counts[i] + weight * towards[i]) / all;
  return shares;
}

StoredAlphabet stored(const Shares& shares, std::uint32_t samples, int table) {
  StoredAlphabet alphabet;
  alphabet.confidence = samples < 300 ? 0 : 1;
  for (std::size_t i = 0; i < static_cast<std::size_t>(symbols_of_table(table)); ++i) {
    alphabet.rarity[i] = rarity_of(shares[i]);
  }
  return alphabet;
}

struct TrainedTable {
  StoredTable table;
  double bits = 0.0;
};

TrainedTable train_table(std::vector<std::uint64_t> samples, int table,
                         const TrainingOptions& options, const Logarithms& logs) {
  constexpr double kWeight = 8.0;
  TrainedTable trained;
  const GreedyMask greedy(
      logs, is_causal_table(table) ? options.causal_alphabet_cost : options.alphabet_cost);
  const std::uint64_t allowed = allowed_bits(table);
  const auto symbols = static_cast<std::size_t>(symbols_of_table(table));
  const std::uint64_t mask = greedy.choose(
      samples, allowed, is_causal_table(table) ? options.causal_table_bits : options.table_bits);
  trained.table.mask = mask;
  std::vector<std::vector<std::uint64_t>> cells(std::size_t{1} << std::popcount(mask));
  Counts all{};
  for (const std::uint64_t sample : samples) {
    cells[gather(sample, mask)].push_back(sample);
    ++all[sample >> kSymbol];
  }
  Shares even{};
  for (std::size_t i = 0; i < symbols; ++i) even[i] = 1.0 / static_cast<double>(symbols);
  const Shares of_table = shares_of(all, even, 1.0);
  for (std::vector<std::uint64_t>& cell : cells) {
    const std::uint64_t cell_mask = greedy.choose(cell, allowed & ~mask, options.cell_bits);
    trained.table.cells.push_back(cell_mask);
    Counts whole{};
    std::vector<std::vector<std::uint64_t>> parts(std::size_t{1} << std::popcount(cell_mask));
    for (const std::uint64_t sample : cell) {
      parts[gather(sample, cell_mask)].push_back(sample);
      ++whole[sample >> kSymbol];
    }
    // An alphabet with few samples is drawn towards its cell, and a cell with few towards its
    // table.
    const Shares of_cell = shares_of(whole, of_table, kWeight);
    for (std::vector<std::uint64_t>& part : parts) {
      const std::uint64_t part_mask =
          greedy.choose(part, allowed & ~mask & ~cell_mask, options.part_bits);
      trained.table.parts.push_back(part_mask);
      std::vector<Counts> counts(std::size_t{1} << std::popcount(part_mask));
      Counts of_part{};
      for (const std::uint64_t sample : part) {
        ++counts[gather(sample, part_mask)][sample >> kSymbol];
        ++of_part[sample >> kSymbol];
      }
      const Shares near = shares_of(of_part, of_cell, kWeight);
      for (const Counts& c : counts) {
        trained.table.alphabets.push_back(stored(shares_of(c, near, kWeight), sum(c), table));
        trained.bits += greedy.bits(c);
      }
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

void for_each_symbol_of(const Svo& svo,
                        const std::function<void(int table, std::uint64_t word, int symbol)>& use) {
  if (svo.node_count() == 0) return;
  SliceLevel level = root_level();
  for (int number = 0; number < svo.depth; ++number) {
    const std::size_t begin = svo.level_begin[static_cast<std::size_t>(number)];
    const std::size_t children = svo.node_count(number + 1);
    const int level_class = pointreel::level_class(number, level.size(), children);
    const auto use_halves = [&](std::uint64_t word, std::uint32_t mask, int low_half) {
      use(table_of(level_class, SymbolKind::low_half), word, static_cast<int>(mask & 15u));
      use(table_of(level_class, SymbolKind::high_half),
          word | std::uint64_t{mask & 15u} << low_half, static_cast<int>(mask >> 4));
    };
    for (std::size_t i = 0; i < level.size(); ++i) {
      level.masks[i] = svo.masks[begin + level.rank[i]];
    }
    if (level_class >= kFirstCausalClass) {
      CausalWalk walk(level);
      for (std::size_t slice = 0; slice < level.slice_count(); ++slice) {
        walk.visit(slice, [&](std::uint32_t node, std::uint64_t word) -> std::uint32_t {
          use_halves(word, level.masks[node], causal_word::kLowHalf);
          return level.masks[node];
        });
      }
    } else {
      SparseWalk walk(level);
      for (std::size_t slice = 0; slice < level.slice_count(); ++slice) {
        walk.visit(slice);
        for (std::size_t i = 0; i < walk.size(); ++i) {
          const std::uint32_t mask =
              orientation::kTurned[walk.orientation(i)][level.masks[level.slices[slice].begin + i]];
          const bool only = std::has_single_bit(mask);
          use(table_of(level_class, SymbolKind::only_child), walk.word(i),
              only ? std::countr_zero(mask) : kMore);
          if (!only) use_halves(walk.word(i), mask, sparse_word::kLowHalf);
        }
      }
    }
    std::vector<std::uint32_t> first_child(level.size());
    for (std::size_t i = 0; i < level.size(); ++i) {
      first_child[i] =
          svo.first_child[begin + i] - svo.level_begin[static_cast<std::size_t>(number) + 1];
    }
    SliceLevel below;
    expand(level, first_child, children, below);
    level = std::move(below);
  }
}

void ContextTrainer::add(const Svo& svo) {
  for_each_symbol_of(svo, [this](int table, std::uint64_t word, int symbol) {
    samples_[static_cast<std::size_t>(table)].push_back(word | static_cast<std::uint64_t>(symbol)
                                                                   << kSymbol);
  });
}

std::size_t ContextTrainer::sample_count() const {
  std::size_t count = 0;
  for (const auto& samples : samples_) count += samples.size();
  return count;
}

ContextTrainer::Result ContextTrainer::train(const TrainingOptions& options) const {
  const Logarithms logs;
  std::vector<TrainedTable> trained(kTables);
  tbb::parallel_for(0, kTables, [&](int table) {
    const auto i = static_cast<std::size_t>(table);
    trained[i] = train_table(samples_[i], table, options, logs);
  });
  Result result;
  double bits = 0.0;
  for (std::size_t i = 0; i < trained.size(); ++i) {
    result.cells += trained[i].table.cells.size();
    result.alphabets += trained[i].table.alphabets.size();
    bits += trained[i].bits;
    result.tables[i] = std::move(trained[i].table);
  }
  result.bits_per_symbol = bits / static_cast<double>(std::max<std::size_t>(1, sample_count()));
  return result;
}

}  // namespace pointreel
