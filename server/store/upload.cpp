#include "server/store/upload.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <fstream>
#include <iterator>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include "codec/package/manifest.h"
#include "common/base/running_checksum.h"
#include "common/base/try.h"
#include "pointreel/package.h"
#include "server/store/object_store.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

/// Uploads at the same time.
constexpr std::size_t kConnections = 4;
/// After this many files in a row that the store lacks, it is no longer asked about short files
/// that its manifest does not name. An interrupted upload leaves fewer gaps before the last file
/// that it sent.
constexpr std::size_t kMissesInARow = kConnections;
/// Asking takes as long as sending a file of about this size from the same building.
constexpr std::uint64_t kShort = std::uint64_t{1} << 20;
/// What Amazon takes in one request.
constexpr std::uint64_t kLargest = std::uint64_t{5} << 30;
/// How often a recording is looked at. Its segments last a second.
constexpr std::chrono::milliseconds kPoll{500};

constexpr const char* kForGood = "public, max-age=31536000, immutable";

/// A package's manifest as text, with what its journal adds, and what it says.
struct ManifestText {
  std::string text;
  Manifest manifest;
};

/// Whether a program is recording into the folder: it holds a lock of it (RecordedPackage).
bool is_being_recorded(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool locked = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0;
  ::close(descriptor);
  return locked;
}

Result<ManifestText> read_manifest_text(const fs::path& folder) {
  ManifestText read;
  read.manifest = TRY(read_manifest(folder));
  if (read.manifest.live && !is_being_recorded(folder)) {
    // Its program was killed, or has ended just now: what is there now is all of it.
    read.manifest = TRY(read_manifest(folder));
    read.manifest.live.reset();
  }
  read.text = write_manifest(read.manifest);
  return read;
}

Result<std::uint64_t> checksum_of(const ObjectContent& content) {
  RunningChecksum checksum;
  std::string block(std::size_t{1} << 20, '\0');
  for (std::uint64_t offset = 0; offset < content.bytes();) {
    const std::size_t size = content.read(offset, block.data(), block.size());
    if (size == 0) return fail(ErrorCode::io, "cannot be read to its end");
    checksum.add({reinterpret_cast<const std::uint8_t*>(block.data()), size});
    offset += size;
  }
  return checksum.value();
}

/// The paths of the files that a manifest names; none if there is no manifest.
std::set<std::string> named_by(const std::string& manifest) {
  std::set<std::string> paths;
  if (const auto parsed = parse_manifest(manifest))
    for (const PackageFile* file : parsed->files()) paths.insert(file->path);
  return paths;
}

/// Uploads the files of one package, from several threads.
class FileUploads {
 public:
  /// `named` are the files of the manifest that is in the store.
  FileUploads(const UploadOptions& options, const HttpFolder& to, const fs::path& package,
              std::set<std::string> named, const UploadListener& listener, UploadSummary& summary)
      : options_(options),
        to_(to),
        package_(package),
        named_(std::move(named)),
        listener_(listener),
        summary_(summary) {}

  /// Stops at the first error.
  Result<void> run(const std::vector<const PackageFile*>& files, const AudioFile* audio) {
    files_ = &files;
    audio_ = audio;
    next_ = 0;
    error_.reset();
    {
      std::vector<std::jthread> threads;
      for (std::size_t i = 0; i < std::min(kConnections, files.size()); ++i)
        threads.emplace_back([this] { work(); });
    }
    if (error_) return tl::unexpected(*error_);
    return {};
  }

 private:
  void work() {
    ObjectStore store(options_.http, *to_.access);
    while (const PackageFile* file = next()) {
      const Result<bool> sent = upload(store, *file);
      const std::lock_guard lock(mutex_);
      if (!sent) {
        if (!error_) error_ = sent.error();
        return;
      }
      if (*sent) {
        ++summary_.files;
        summary_.bytes += file->bytes;
      } else {
        ++summary_.kept;
      }
      if (listener_.file_done) listener_.file_done();
    }
  }

  const PackageFile* next() {
    const std::lock_guard lock(mutex_);
    return error_ || next_ == files_->size() ? nullptr : (*files_)[next_++];
  }

  /// Files go up in the order of the manifest, so an interrupted upload has left the first ones.
  bool may_be_there(const PackageFile& file) {
    const std::lock_guard lock(mutex_);
    return file.bytes > kShort || misses_ < kMissesInARow || named_.contains(file.path);
  }

  Result<bool> is_there(ObjectStore& store, const std::string& url, const PackageFile& file,
                        const ObjectContent& content) {
    if (!may_be_there(file)) return false;
    const auto there = TRY(store.look(url));
    {
      const std::lock_guard lock(mutex_);
      misses_ = there ? 0 : misses_ + 1;
    }
    if (!there || there->bytes != file.bytes || there->checksum != file.checksum) return false;
    // The checksum is what was sent with it; this is what has arrived.
    return !there->md5 || *there->md5 == TRY(content.md5());
  }

  /// False if it was there already.
  Result<bool> upload(ObjectStore& store, const PackageFile& file) {
    const std::string url = to_.file(file.path);
    const fs::path path = package_ / file.path;
    const ObjectContent content = TRY(ObjectContent::open(path));
    if (TRY(is_there(store, url, file, content))) return false;
    const std::uint64_t checksum = TRY(at_place(path.string(), checksum_of(content)));
    if (content.bytes() != file.bytes || checksum != file.checksum)
      return fail(
          fmt::format("{}: has other bytes than {} says, so it is not uploaded; run "
                      "pointreel-server verify",
                      path.string(), kManifestName));
    if (file.bytes > kLargest)
      return fail(ErrorCode::limit, path.string() +
                                        ": has more than 5 GiB, which no store takes "
                                        "at once; pack with a smaller --segment");
    const bool sound = &file == audio_;
    TRY(store.put(url, content,
                  {sound ? "audio/ogg" : "application/octet-stream", kForGood, file.checksum}));
    return true;
  }

  const UploadOptions& options_;
  const HttpFolder& to_;
  const fs::path& package_;
  const std::set<std::string> named_;
  const UploadListener& listener_;
  const std::vector<const PackageFile*>* files_ = nullptr;
  const AudioFile* audio_ = nullptr;
  std::mutex mutex_;  ///< guards what follows
  UploadSummary& summary_;
  std::size_t next_ = 0;
  std::size_t misses_ = 0;  ///< files that were not there, since the last one that was
  std::optional<Error> error_;
};

/// Whether a manifest may take the place of another one without --force: the same recording, which
/// has grown.
bool continues(const Manifest& fresh, const Manifest& before) {
  if (before.segments.empty() || before.segments.size() > fresh.segments.size()) return false;
  // The last segment of a recording that was still growing may be another one by now.
  const std::size_t same = before.live ? 1 : before.segments.size();
  return std::equal(before.segments.begin(),
                    before.segments.begin() + static_cast<std::ptrdiff_t>(same),
                    fresh.segments.begin(), [](const Segment& a, const Segment& b) {
                      const LayerFile &ours = a.layers.front(), &theirs = b.layers.front();
                      return ours.path == theirs.path && ours.bytes == theirs.bytes &&
                             ours.checksum == theirs.checksum;
                    });
}

void wait(std::chrono::milliseconds time, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, time, [] { return false; });
}

}  // namespace

Result<Uploader> Uploader::open(UploadOptions options) {
  if (!is_store_address(options.to))
    return fail(ErrorCode::argument,
                options.to + ": is not an address in an object store; give s3://BUCKET/REEL");
  Uploader uploader;
  uploader.folder_ = TRY(resolve_folder(options.to, options.http.endpoint));
  uploader.options_ = std::move(options);
  ObjectStore store(uploader.options_.http, *uploader.folder_.access);
  if (auto there = TRY(store.get(uploader.folder_.manifest(), kMaxManifestBytes)))
    uploader.there_ = std::move(*there);
  return uploader;
}

Result<void> Uploader::may_replace(const Manifest& fresh) const {
  const auto before = parse_manifest(there_);
  // What is no store may answer anything, and with anything.
  if (!before)
    return fail(ErrorCode::argument,
                fmt::format("{}: what is there already is not a reel ({}); check --endpoint and "
                            "the address, or replace it with --force",
                            options_.to, before.error().message));
  if (continues(fresh, *before)) return {};
  return fail(ErrorCode::argument,
              options_.to + ": another reel is there already; --force replaces it");
}

Result<UploadSummary> Uploader::upload(const fs::path& package, const UploadListener& listener) {
  UploadSummary summary;
  std::set<std::string> done;
  for (bool first = true;; first = false) {
    const ManifestText now = TRY(read_manifest_text(package));
    summary.growing = now.manifest.live.has_value();
    // With --force, what is there under the same manifest is compared, and mended.
    if (now.text != there_ || (first && options_.force)) {
      if (first && !there_.empty() && !options_.force) TRY(may_replace(now.manifest));
      std::vector<const PackageFile*> files = now.manifest.files();
      std::erase_if(files, [&](const PackageFile* file) { return done.contains(file->path); });
      if (listener.begin && first) listener.begin(files.size());
      const UploadListener nobody;
      FileUploads uploads(options_, folder_, package, named_by(there_), first ? listener : nobody,
                          summary);
      TRY(uploads.run(files, now.manifest.audio ? &*now.manifest.audio : nullptr));
      for (const PackageFile* file : files) done.insert(file->path);
      const std::string& text = now.text;
      ObjectStore store(options_.http, *folder_.access);
      TRY(store.put(folder_.manifest(), ObjectContent(text),
                    {"application/json", "no-cache",
                     pointreel::checksum_of(ByteView(
                         reinterpret_cast<const std::uint8_t*>(text.data()), text.size()))}));
      there_ = text;
      ++summary.files;
      summary.bytes += text.size();
    } else if (first) {
      summary.kept = now.manifest.files().size() + 1;
    }
    if (!summary.growing || !options_.follow) return summary;
    wait(kPoll, options_.http.stop);
    if (options_.http.stop.stop_requested()) return fail(ErrorCode::cancelled, "interrupted");
  }
}

}  // namespace pointreel
