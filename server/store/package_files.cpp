#include "server/store/package_files.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "codec/package/http_folder.h"
#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "common/file_system/scratch_folder.h"
#include "common/http/http_client.h"
#include "common/net/url.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

/// Files are fetched in pieces of this size, several at a time.
constexpr std::uint64_t kPiece = 4u << 20;
constexpr std::size_t kPiecesAtATime = 8;

}  // namespace

class PackageFiles::Remote {
 public:
  Remote(HttpFolder folder, const HttpOptions& options)
      : folder_(std::move(folder)), stop_(options.stop), client_(options, folder_.access) {}

  const HttpFolder& folder() const { return folder_; }

  Result<Manifest> manifest() {
    const std::string url = folder_.manifest();
    const Bytes text = TRY(client_.get(url, kMaxManifestBytes));
    return at_place(without_secrets(url),
                    parse_manifest({reinterpret_cast<const char*>(text.data()), text.size()}));
  }

  Result<fs::path> local(const PackageFile& file) {
    Entry* entry = nullptr;
    {
      const std::lock_guard lock(mutex_);
      entry = &entries_[file.path];
    }
    const std::lock_guard lock(entry->mutex);
    if (!entry->path) entry->path = fetch(file);
    return *entry->path;
  }

  std::optional<Error> lacks_room() {
    const std::lock_guard lock(mutex_);
    return lacks_room_;
  }

 private:
  struct Entry {
    std::mutex mutex;
    std::optional<Result<fs::path>> path;
  };

  Result<fs::path> folder_for_files() {
    const std::lock_guard lock(mutex_);
    return temporary_.path(
        ": cannot be created, and fetched files need a folder; set TMPDIR to a folder that has "
        "room");
  }

  Result<fs::path> fetch(const PackageFile& file) {
    const fs::path path = TRY(folder_for_files()) / file.path;
    const std::string url = folder_.file(file.path);
    std::ofstream out(path, std::ios::binary);
    for (std::uint64_t offset = 0; offset < file.bytes;) {
      std::vector<HttpClient::Range> ranges;
      for (; offset < file.bytes && ranges.size() < kPiecesAtATime; offset += kPiece)
        ranges.push_back({url, offset, std::min(kPiece, file.bytes - offset), file.bytes});
      for (const Bytes& bytes : TRY(client_.get_ranges(ranges, stop_)))
        out.write(reinterpret_cast<const char*>(bytes.data()),
                  static_cast<std::streamsize>(bytes.size()));
    }
    out.close();
    if (out) return path;
    const Error error{path.string() + ": cannot be written; set TMPDIR to a folder that has room",
                      ErrorCode::io};
    const std::lock_guard lock(mutex_);
    lacks_room_ = error;
    return tl::unexpected(error);
  }

  const HttpFolder folder_;
  const std::stop_token stop_;
  HttpClient client_;
  std::mutex mutex_;  ///< guards what follows
  std::map<std::string, Entry> entries_;
  std::optional<Error> lacks_room_;
  ScratchFolder temporary_;
};

Result<PackageFiles> PackageFiles::at(const std::string& where, const HttpOptions& options) {
  PackageFiles files(where);
  if (!scheme_of(where).empty() && !is_folder_address(where)) {
    TRY(parse_url(where));
    return fail(ErrorCode::argument,
                without_secrets(where) + ": is not an http://, https:// or s3:// address");
  }
  if (is_folder_address(where))
    files.remote_ = std::make_shared<Remote>(TRY(resolve_folder(where, options.endpoint)), options);
  return files;
}

Result<Manifest> PackageFiles::manifest() const {
  return remote_ ? remote_->manifest() : read_manifest(folder_);
}

Result<fs::path> PackageFiles::local(const PackageFile& file) const {
  if (remote_) return remote_->local(file);
  return folder_ / file.path;
}

std::optional<Error> PackageFiles::lacks_room() const {
  return remote_ ? remote_->lacks_room() : std::nullopt;
}

std::string PackageFiles::shown() const {
  return remote_ ? without_secrets(remote_->folder().base) : folder_.string();
}

std::string PackageFiles::shown(const PackageFile& file) const {
  return remote_ ? without_secrets(remote_->folder().file(file.path))
                 : (folder_ / file.path).string();
}

}  // namespace pointreel
