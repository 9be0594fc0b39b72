#include "client/web/wasm/tables.h"

#include <string_view>

#include "client/source/fetched.h"
#include "client/web/wasm/errors.h"
#include "codec/core/json_fields.h"
#include "codec/octree/context_tables.h"

using namespace pointreel;

#if defined(__wasm__)
#include "codec/octree/stored_tables.h"

namespace {

Bytes tables_of_format;

}  // namespace

ByteView pointreel::stored_tables() { return tables_of_format; }

PrError pr_load_tables(const std::uint8_t* bytes, std::uint32_t size) {
  tables_of_format.assign(bytes, bytes + size);
  const auto tables = tables_of_number(kNewestTables);
  return tables ? PR_OK : report(tables.error());
}
#else
// The native library has them built in.
PrError pr_load_tables(const std::uint8_t*, std::uint32_t) { return PR_OK; }
#endif

PrTables* pr_tables_new(const std::uint8_t* bytes, std::uint32_t size, const char* checksum,
                        std::uint32_t checksum_size) {
  const auto expected = parse_hex(std::string_view(checksum, checksum_size));
  const PackageFile file{"", size, expected.value_or(0)};
  auto tables = read_tables(file, {bytes, size});
  if (tables) return new PrTables{*std::move(tables)};
  report(tables.error());
  return nullptr;
}

void pr_tables_free(PrTables* tables) { delete tables; }
