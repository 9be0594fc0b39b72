#include "codec/octree/stored_tables.h"

#include <cstddef>

namespace pointreel {

/// What the build makes of the file.
extern const unsigned char kTables1[];
extern const std::size_t kTables1Size;

ByteView stored_tables() { return {kTables1, kTables1Size}; }

}  // namespace pointreel
