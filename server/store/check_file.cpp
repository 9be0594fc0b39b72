#include "server/store/check_file.h"

#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "common/base/running_checksum.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/file_system/open_file.h"
#include "pointreel/bytes.h"

namespace pointreel {

Result<void> check_size(const std::filesystem::path& path, const PackageFile& file) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return fail(ErrorCode::io, error.message());
  if (size != file.bytes)
    return fail(fmt::format("has {}, the manifest says {}", counted(size, "byte"), file.bytes));
  return {};
}

Result<void> check_checksum(const std::filesystem::path& path, const PackageFile& file) {
  RunningChecksum checksum;
  std::ifstream in = TRY(open_stream(path));
  Bytes block(1 << 20);
  while (in) {
    in.read(reinterpret_cast<char*>(block.data()), static_cast<std::streamsize>(block.size()));
    checksum.add({block.data(), static_cast<std::size_t>(in.gcount())});
  }
  if (!in.eof()) return fail(ErrorCode::io, "cannot be read");
  if (checksum.value() != file.checksum)
    return fail(fmt::format("has the checksum {:016x}, the manifest says {:016x}", checksum.value(),
                            file.checksum));
  return {};
}

}  // namespace pointreel
