#include "codec/training/sequence_tables.h"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "codec/octree/context_model.h"
#include "codec/octree/context_tables.h"
#include "codec/training/context_trainer.h"
#include "common/base/try.h"
#include "pointreel/package.h"

namespace pointreel {
namespace {

/// The measured size of an alphabet in a table file, including its share of the masks, in bits.
constexpr double kStoredAlphabetBits = 50.0;
/// The number of bits that an alphabet must save beyond that. With fewer, tables would fit the
/// samples and no other frame.
constexpr double kAlphabetMargin = 20.0;

/// The number of bits that symbols take, by table.
using TableBits = std::array<double, kTables>;

/// The cost in bits of coding a symbol with each frequency.
std::vector<float> make_costs() {
  std::vector<float> costs(kAllFrequencies + 1);
  for (int f = 1; f <= kAllFrequencies; ++f) {
    costs[static_cast<std::size_t>(f)] =
        static_cast<float>(-portable_log2(static_cast<double>(f) / kAllFrequencies));
  }
  return costs;
}

/// Adds the cost of coding the tree.
void add_cost(const Svo& svo, const ContextTables& tables, const std::vector<float>& costs,
              TableBits& bits) {
  std::vector<Alphabet16> alphabets = tables.alphabets;
  for_each_symbol_of(svo, [&](int table, std::uint64_t word, int symbol) {
    const auto i = static_cast<std::size_t>(table);
    Alphabet16& alphabet = alphabets[tables.find<PortableExtract>(tables.tables[i], word)];
    bits[i] += double{costs[alphabet.range(symbol).size]};
    alphabet.update(symbol);
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
  // An alphabet is stored once, but saves as much in every frame as it does in the few samples.
  const double total = static_cast<double>(frames);
  TrainingOptions options;
  options.alphabet_cost = options.causal_alphabet_cost =
      kAlphabetMargin + kStoredAlphabetBits * std::min(1.0, learnt / total);
  ContextTrainer::Result trained = trainer.train(options);
  const auto own = parse_tables(write_tables(trained.tables));
  if (!own) return SequenceTables{};  // they have more alphabets than tables may have

  const std::vector<float> costs = make_costs();
  TableBits built_in_bits{}, own_bits{};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!judges(i)) continue;
    add_cost(samples[i], *built_in, costs, built_in_bits);
    add_cost(samples[i], *own, costs, own_bits);
    judged += 1.0;
  }
  const double scale = total / judged;
  double saved_bits = 0.0;
  for (std::size_t i = 0; i < trained.tables.size(); ++i) {
    const double saved = (built_in_bits[i] - own_bits[i]) * scale;
    const double stored =
        kStoredAlphabetBits * static_cast<double>(trained.tables[i].alphabets.size());
    if (saved > stored) {
      saved_bits += saved;
    } else {
      trained.tables[i] = {kBaseTable, {}, {}, {}};
    }
  }
  SequenceTables result;
  Bytes file = TRY(write_table_file(write_tables(trained.tables)));
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
