#include "client/source/file_source.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "client/source/package_source.h"
#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "common/file_system/open_file.h"

namespace pointreel {
namespace {

Result<Bytes> read_range(const std::filesystem::path& folder, const PackageFile& listed,
                         std::uint64_t offset, std::uint64_t size) {
  if (size == 0) return Bytes{};
  const std::filesystem::path path = folder / listed.path;
  const OpenFile file = TRY(at_place(path.string(), OpenFile::open(path)));
  // The file's length is checked before memory is taken, because the manifest may be wrong.
  if (file.size() < offset + size)
    return fail(
        fmt::format("{}: ends at byte {}, but by the manifest the frame's bytes end at {}; the "
                    "package is damaged",
                    path.string(), file.size(), offset + size));
  Bytes bytes(size);
  std::size_t got = 0;
  while (got < size) {
    const ssize_t n = ::pread(file.descriptor(), bytes.data() + got, size - got,
                              static_cast<off_t>(offset + got));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0)
      return fail(ErrorCode::io,
                  fmt::format("{}: cannot be read at byte {}: {}", path.string(), offset + got,
                              n < 0 ? std::strerror(errno) : "the file has become shorter"));
    got += static_cast<std::size_t>(n);
  }
  return bytes;
}

class FileSource : public PackageSource {
 public:
  FileSource(std::filesystem::path folder, Manifest manifest,
             std::shared_ptr<const ContextTables> tables)
      : PackageSource(std::move(manifest), std::move(tables)), folder_(std::move(folder)) {}

  Result<Bytes> fetch_audio(std::uint64_t offset, std::uint64_t size,
                            const std::stop_token& /*stop*/) override {
    return read_range(folder_, *manifest().audio, offset, size);
  }

 private:
  Result<std::vector<Bytes>> read(std::span<const FileRange> ranges,
                                  const FetchRequest& request) override {
    std::vector<Bytes> all;
    for (const FileRange& range : ranges) {
      if (request.stop.stop_requested()) return fail(ErrorCode::cancelled, "cancelled");
      all.push_back(TRY(read_range(folder_, *range.file, range.offset, range.bytes())));
    }
    return all;
  }

  const std::filesystem::path folder_;
};

}  // namespace

Result<std::unique_ptr<Source>> open_file_source(const std::filesystem::path& folder) {
  auto manifest = read_manifest(folder);
  if (!manifest) return tl::unexpected(no_package(manifest.error()));
  std::shared_ptr<const ContextTables> tables;
  if (manifest->tables) {
    const PackageFile& file = *manifest->tables;
    const Bytes bytes = TRY(read_range(folder, file, 0, file.bytes));
    auto read = read_tables(file, bytes);
    if (!read) return fail_at((folder / file.path).string(), read.error());
    tables = std::move(*read);
  }
  return std::make_unique<FileSource>(folder, std::move(*manifest), std::move(tables));
}

}  // namespace pointreel
