#include "codec/octree/context_tables.h"

#include <utility>

#include <zstd.h>

#include "codec/octree/stored_tables.h"
#include "common/base/concat.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"
#include "pointreel/package.h"

namespace pointreel {

namespace {

constexpr std::size_t kMostUnpacked = std::size_t{1} << 22;

Result<ContextTables> unpack(ByteView packed, const ContextTables* base) {
  const auto size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (size > kMostUnpacked)
    return fail("context tables are not a zstd frame of a known size up to 4 MiB");
  Bytes bytes(static_cast<std::size_t>(size));
  if (ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size()) != size) {
    return fail("context tables are damaged");
  }
  return parse_tables(bytes, base);
}

Result<std::shared_ptr<const ContextTables>> shared(Result<ContextTables> tables) {
  return std::make_shared<const ContextTables>(TRY(std::move(tables)));
}

}  // namespace

Result<std::shared_ptr<const ContextTables>> tables_of_number(std::uint8_t number) {
  if (number != 1) {
    return fail(ErrorCode::unsupported,
                concat("frame needs context tables ", number,
                       ", which this version does not have: update Pointreel"));
  }
  static const auto tables = shared(unpack(stored_tables(), nullptr));
  return tables;
}

Result<Bytes> write_table_file(ByteView tables) {
  Bytes file(1 + ZSTD_compressBound(tables.size()));
  file.front() = kNewestTables;
  const std::size_t size = ZSTD_compress(file.data() + 1, file.size() - 1, tables.data(),
                                         tables.size(), ZSTD_maxCLevel());
  if (ZSTD_isError(size)) return fail("context tables cannot be compressed");
  file.resize(1 + size);
  return file;
}

namespace {

Result<std::shared_ptr<const ContextTables>> read(ByteView file) {
  if (file.empty()) return fail("context tables are cut short");
  if (file.size() > kMaxTablesBytes) {
    return fail(ErrorCode::limit, "context tables are larger than 1 MiB");
  }
  const auto base = TRY(tables_of_number(file.front()));
  ContextTables tables = TRY(unpack(file.subspan(1), base.get()));
  tables.checksum = checksum_of(file);
  return std::make_shared<const ContextTables>(std::move(tables));
}

}  // namespace

Result<std::shared_ptr<const ContextTables>> read_table_file(ByteView file) {
  return or_out_of_memory([&] { return read(file); });
}

}  // namespace pointreel
