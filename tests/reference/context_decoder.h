#pragma once

#include <cstdint>

#include "common/base/bytes.h"
#include "common/base/error.h"

namespace pointreel::reference {

/// One layer's payload of entropy coding context, and which levels' masks it holds.
struct ContextLayer {
  ByteView payload;
  int first_level = 0, last_level = 0;
};

/// Decodes layers as codec/FORMAT.md tells it ("Entropy coding context"), in the plainest way: sets
/// of cells, words put together bit by bit, tables read from the file as it is. Knows nothing of
/// the codec's code. `tables_file` is the content of codec/octree/tables/1.zst,
/// `own_tables` of the package's table file, if it has one. Returns the masks,
/// level by level in Morton order. For valid payloads only: others may give any masks or an error.
Result<Bytes> decode_context_layers(const std::vector<ContextLayer>& layers, ByteView tables_file,
                                    ByteView own_tables = {});

}  // namespace pointreel::reference
