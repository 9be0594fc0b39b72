#include "pointreel/bytes.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace pointreel {

std::uint64_t checksum_of(ByteView bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

}  // namespace pointreel
