#include "codec/octree/mask_coder.h"

#include <bit>

#include "codec/octree/orientation.h"

namespace pointreel {
namespace {

/// Codes a slice at a time: first finds the alphabets of all nodes, which do not depend on what is
/// being decoded, then codes their symbols, without a branch on them.
template <class Extract, class Coder>
class SparseCoder {
 public:
  SparseCoder(const ContextTables& tables, int level_class, Alphabet16* alphabets, Coder& symbols)
      : tables_(tables),
        alphabets_(alphabets),
        first_(tables.table(level_class, SymbolKind::only_child)),
        low_(tables.table(level_class, SymbolKind::low_half)),
        high_(tables.table(level_class, SymbolKind::high_half)),
        symbols_(symbols) {}

  /// `masks`: those of the slice, which were last visited by the walk.
  void code(const SparseWalk& walk, std::uint8_t* masks) {
    const std::size_t count = walk.size();
    if (contexts_.size() < count) {
      contexts_.resize(count + count / 2);
      halves_.resize(contexts_.size());
    }
    using orientation::kTurned, orientation::kTurnedBack;
    if constexpr (Coder::kEncodes) {
      for (std::size_t i = 0; i < count; ++i) masks[i] = kTurned[walk.orientation(i)][masks[i]];
    }
    code_halves(walk, masks, code_only_children(walk, masks));
    for (std::size_t i = 0; i < count; ++i) masks[i] = kTurnedBack[walk.orientation(i)][masks[i]];
  }

 private:
  /// Returns the number of the other nodes, which are put into `halves_`.
  std::size_t code_only_children(const SparseWalk& walk, std::uint8_t* masks) {
    const std::size_t count = walk.size();
    for (std::size_t i = 0; i < count; ++i) {
      contexts_[i] = tables_.find<Extract>(first_, walk.word(i));
    }
    std::size_t others = 0;
    Coder symbols = std::move(symbols_);
    const auto code_one = [&](std::size_t i, int state) {
      int symbol = 0;
      if constexpr (Coder::kEncodes) {
        symbol = std::has_single_bit(masks[i]) ? std::countr_zero(masks[i]) : kMore;
      }
      symbol = symbols.code(state, alphabets_[contexts_[i]], symbol);
      if constexpr (!Coder::kEncodes) masks[i] = static_cast<std::uint8_t>(1u << symbol);
      halves_[others] = static_cast<std::uint32_t>(i);
      others += symbol >= kMore ? 1 : 0;
    };
    std::size_t i = 0;
    for (; i + 2 <= count; i += 2) {
      code_one(i, 0);
      code_one(i + 1, 1);
    }
    if (i < count) code_one(i, 0);
    symbols_ = std::move(symbols);
    return others;
  }

  /// Codes the masks of the first `count` nodes in `halves_`, half by half.
  void code_halves(const SparseWalk& walk, std::uint8_t* masks, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) {
      contexts_[k] = tables_.find<Extract>(low_, walk.word(halves_[k]));
    }
    Coder symbols = std::move(symbols_);
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint32_t i = halves_[k];
      const int low = symbols.code(0, alphabets_[contexts_[k]], masks[i] & 15);
      const std::uint64_t word = walk.word(i) | static_cast<std::uint64_t>(low)
                                                    << sparse_word::kLowHalf;
      const int high =
          symbols.code(1, alphabets_[tables_.find<Extract>(high_, word)], masks[i] >> 4);
      if constexpr (!Coder::kEncodes) masks[i] = static_cast<std::uint8_t>(low | high << 4);
    }
    symbols_ = std::move(symbols);
  }

  const ContextTables& tables_;
  Alphabet16* const alphabets_;
  const ContextTables::Table &first_, &low_, &high_;
  Coder& symbols_;
  std::vector<std::uint32_t> contexts_, halves_;
};

template <class Extract, class Coder>
void code_sparse(MaskCoder<Coder>& coder, SliceLevel& level, int level_class, std::size_t first,
                 std::size_t end) {
  SparseWalk walk(level);
  SparseCoder<Extract, Coder> slices(coder.tables, level_class, coder.alphabets.data(),
                                     coder.symbols);
  for (std::size_t slice = first; slice < end; ++slice) {
    walk.visit(slice);
    slices.code(walk, level.masks.data() + level.slices[slice].begin);
  }
}

constexpr std::size_t kLargeLevel = 16384;

template <class Extract, class Coder>
void code_causal(MaskCoder<Coder>& coder, SliceLevel& level, int level_class, std::size_t first,
                 std::size_t end) {
  const ContextTables& tables = coder.tables;
  const ContextTables::Table &low_table = tables.table(level_class, SymbolKind::low_half),
                             &high_table = tables.table(level_class, SymbolKind::high_half);
  Alphabet16* const alphabets = coder.alphabets.data();
  if (level_class == kDenseClass && level.size() >= kLargeLevel) {
    // Large dense levels are very regular, each in its own way, so they are learned anew.
    const std::size_t dense = tables.first_dense_alphabet();
    for (std::size_t i = dense; i < coder.alphabets.size(); ++i) alphabets[i].set_seen(0);
  }
  const std::uint8_t* masks = level.masks.data();
  CausalWalk walk(level);
  Coder symbols = std::move(coder.symbols);
  for (std::size_t slice = first; slice < end; ++slice) {
    walk.visit(slice, [&](std::uint32_t i, std::uint64_t word) {
      const int low =
          symbols.code(0, alphabets[tables.find<Extract>(low_table, word)], masks[i] & 15);
      word |= static_cast<std::uint64_t>(low) << causal_word::kLowHalf;
      const int high =
          symbols.code(1, alphabets[tables.find<Extract>(high_table, word)], masks[i] >> 4);
      return static_cast<std::uint32_t>(low | high << 4);
    });
  }
  coder.symbols = std::move(symbols);
}

template <class Extract, class Coder>
void code_level(MaskCoder<Coder>& coder, SliceLevel& level, int level_class, std::size_t first,
                std::size_t end) {
  if (level_class >= kFirstCausalClass) {
    code_causal<Extract>(coder, level, level_class, first, end);
  } else {
    code_sparse<Extract>(coder, level, level_class, first, end);
  }
}

#if defined(__x86_64__)
/// Compiles a function and everything that it calls for processors with BMI2, whose shifts are
/// faster too.
template <class Coder>
[[gnu::flatten, gnu::target("bmi2")]] void code_level_bmi2(MaskCoder<Coder>& coder,
                                                           SliceLevel& level, int level_class,
                                                           std::size_t first, std::size_t end) {
  code_level<HardwareExtract>(coder, level, level_class, first, end);
}
#endif

}  // namespace

template <class Coder>
void MaskCoder<Coder>::code(SliceLevel& level, int level_class, std::size_t first,
                            std::size_t end) {
#if defined(__x86_64__)
  if (hardware) {
    code_level_bmi2(*this, level, level_class, first, end);
    return;
  }
#endif
  code_level<PortableExtract>(*this, level, level_class, first, end);
}

template struct MaskCoder<SymbolEncoder>;
template struct MaskCoder<SymbolDecoder>;

}  // namespace pointreel
