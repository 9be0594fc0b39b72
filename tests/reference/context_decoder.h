#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel::reference {

/// One layer's payload of entropy coding context, which levels' masks it holds, and how many.
struct ContextLayer {
  ByteView payload;
  int first_level = 0, last_level = 0;
  std::size_t masks = 0;
};

/// Context tables as FORMAT.md describes them, one number an entry.
struct Tables {
  struct Entry {
    std::uint64_t mask;
    std::size_t first;
  };
  struct Leaf {
    long long p, n;
  };
  std::vector<Entry> slots, cells;
  std::vector<Leaf> leaves;
};

/// Of a good file, codec/octree/tables/1.zst.
Tables read_tables(ByteView file);

/// Of a package's good table file, based on tables 1.
Tables read_package_tables(ByteView file, const Tables& tables1);

/// Decodes layers as codec/FORMAT.md tells it ("Entropy coding context"), in the plainest way: sets
/// of cells, words put together bit by bit. Knows nothing of the codec's code. `own`: the package's
/// tables, if it has any. Returns the masks, level by level in Morton order. Payloads that do not
/// hold just these masks are errors.
Result<Bytes> decode_context_layers(const std::vector<ContextLayer>& layers, const Tables& tables1,
                                    const Tables* own = nullptr);

}  // namespace pointreel::reference
