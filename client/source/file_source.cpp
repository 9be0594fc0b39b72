#include "client/source/file_source.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

namespace pointreel {
namespace {

/// A file descriptor that closes itself.
class OpenFile {
 public:
  explicit OpenFile(const std::filesystem::path& path)
      : descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~OpenFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

class FileSource : public Source {
 public:
  FileSource(std::filesystem::path folder, Manifest manifest)
      : folder_(std::move(folder)), manifest_(std::move(manifest)) {}

  /// Before the first fetch.
  Result<void> open_tables() {
    if (!manifest_.tables) return {};
    const PackageFile& file = *manifest_.tables;
    const auto bytes = read(file, 0, file.bytes);
    if (!bytes) return tl::unexpected(bytes.error());
    auto tables = read_tables(file, *bytes);
    if (!tables) return fail_at((folder_ / file.path).string(), tables.error());
    tables_ = std::move(*tables);
    return {};
  }

  const Manifest& manifest() const override { return manifest_; }

  Result<FetchedFrame> fetch(std::uint32_t frame, const FetchRequest& request) override {
    const auto ranges = ranges_of(manifest_, frame, request);
    if (!ranges) return tl::unexpected(ranges.error());
    FetchedFrame fetched;
    fetched.tables = tables_;
    for (const LayerRange& range : *ranges) {
      auto bytes = read(*range.file, range.offset, range.sizes.total());
      if (!bytes) return tl::unexpected(bytes.error());
      fetched.layers.push_back({std::move(*bytes), range.sizes});
    }
    return fetched;
  }

 private:
  Result<Bytes> read(const PackageFile& listed, std::uint64_t offset, std::uint64_t size) const {
    if (size == 0) return Bytes{};
    const std::filesystem::path path = folder_ / listed.path;
    const OpenFile file(path);
    if (file.get() < 0)
      return fail(fmt::format("{}: cannot be opened: {}", path.string(), std::strerror(errno)));
    // The file's end is looked at before memory is taken: the manifest may promise what is not
    // there.
    const off_t end = ::lseek(file.get(), 0, SEEK_END);
    if (end < 0 || static_cast<std::uint64_t>(end) < offset + size)
      return fail(
          fmt::format("{}: ends at byte {}, but the manifest says that what is wanted ends at {}; "
                      "the package is damaged",
                      path.string(), static_cast<std::int64_t>(end), offset + size));
    Bytes bytes(size);
    std::size_t got = 0;
    while (got < size) {
      const ssize_t n =
          ::pread(file.get(), bytes.data() + got, size - got, static_cast<off_t>(offset + got));
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0)
        return fail(fmt::format("{}: cannot be read at byte {}: {}", path.string(), offset + got,
                                n < 0 ? std::strerror(errno) : "the file has become shorter"));
      got += static_cast<std::size_t>(n);
    }
    return bytes;
  }

  const std::filesystem::path folder_;
  const Manifest manifest_;
  std::shared_ptr<const ContextTables> tables_;
};

}  // namespace

Result<std::unique_ptr<Source>> open_file_source(const std::filesystem::path& folder) {
  auto manifest = read_manifest(folder);
  if (!manifest) return tl::unexpected(manifest.error());
  auto source = std::make_unique<FileSource>(folder, std::move(*manifest));
  if (const auto opened = source->open_tables(); !opened) return tl::unexpected(opened.error());
  return source;
}

}  // namespace pointreel
