#include "codec/octree/context_tables.h"

#include <string>

#include <zstd.h>

namespace pointreel {

/// The file tables/1.zst, put here by the build.
extern const unsigned char kTables1[];
extern const std::size_t kTables1Size;

namespace {

constexpr std::size_t kMostUnpacked = std::size_t{1} << 24;

Result<std::shared_ptr<const ContextTables>> unpack(ByteView packed) {
  const auto size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (size > kMostUnpacked) return fail("context tables are no zstd frame of a known size");
  Bytes bytes(static_cast<std::size_t>(size));
  if (ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size()) != size) {
    return fail("context tables are damaged");
  }
  auto tables = parse_tables(bytes);
  if (!tables) return tl::unexpected(tables.error());
  return std::make_shared<const ContextTables>(std::move(*tables));
}

}  // namespace

Result<std::shared_ptr<const ContextTables>> tables_of_number(std::uint8_t number) {
  if (number != 1) {
    return fail("frame needs context tables " + std::to_string(number) +
                ", which this version does not have: update Pointreel");
  }
  static const auto tables = unpack({kTables1, kTables1Size});
  return tables;
}

}  // namespace pointreel
