#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/octree/context_model.h"
#include "codec/octree/slice_level.h"
#include "codec/octree/symbol_coder.h"

/// Codes the masks of some slices of a level. FORMAT.md, "Symbols".
namespace pointreel {

/// What codes the masks of a slab's levels.
template <class Coder>
struct MaskCoder {
  const ContextTables& tables;
  std::vector<Alphabet16>& alphabets;
  Coder& symbols;
  bool hardware;

  /// Codes the slices [first, end) of a level of this class. An encoder takes the masks from
  /// `level.masks`, a decoder puts them there. They may be 0 if the bytes are hostile.
  void code(SliceLevel& level, int level_class, std::size_t first, std::size_t end);
};

extern template struct MaskCoder<SymbolEncoder>;
extern template struct MaskCoder<SymbolDecoder>;

}  // namespace pointreel
