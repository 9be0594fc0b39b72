#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/error.h"
#include "tests/reference/symbol_reader.h"

namespace pointreel::reference {

/// The payload of a layer with entropy coding context, the levels whose masks it holds, and their
/// number.
struct ContextLayer {
  ByteView payload;
  int first_level = 0, last_level = 0;
  std::size_t masks = 0;
};

/// A context table as FORMAT.md describes it.
struct Table {
  struct Entry {
    std::uint64_t mask;
    std::size_t first;  ///< the number of the first part or alphabet to which it leads
  };
  std::uint64_t mask = 0;
  std::vector<Entry> cells, parts;
  std::vector<Alphabet> alphabets;
};
using Tables = std::vector<Table>;

/// Reads codec/octree/tables/1.zst, which must be valid.
Tables read_tables(ByteView file);

/// Reads a package's file of tables, which must be valid and is based on tables 1.
Tables read_package_tables(ByteView file, const Tables& tables1);

/// Decodes layers as codec/FORMAT.md describes it ("Entropy coding context"), in the simplest way,
/// with sets of cells and words that are assembled bit by bit, and without any code of the codec.
/// `own`: the package's tables, if it has any. Returns the masks, level by level in Morton order.
/// Fails if a payload does not hold exactly its number of masks.
Result<Bytes> decode_context_layers(const std::vector<ContextLayer>& layers, const Tables& tables1,
                                    const Tables* own = nullptr);

}  // namespace pointreel::reference
