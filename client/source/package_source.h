#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <vector>

#include "client/source/source.h"

namespace pointreel {

/// Adds what to do to an error of reading a manifest: the user may have named something that is not
/// a package at all. A package that is too new for this program keeps its own advice.
Error no_package(const Error& error);

/// A package, wherever its files are. Fetches all that is wanted of a frame at once.
class PackageSource : public Source {
 public:
  const Manifest& manifest() const final { return manifest_; }
  Result<FetchedFrame> fetch(const FetchRequest& request) final;

 protected:
  PackageSource(Manifest manifest, std::shared_ptr<const ContextTables> tables);

  /// The bytes of each range, exactly as many as it says; no range is empty. The error names the
  /// file.
  virtual Result<std::vector<Bytes>> read(std::span<const FileRange> ranges,
                                          const FetchRequest& request) = 0;

 private:
  /// A group of video that was fetched.
  struct Group {
    const LayerFile* file;
    std::uint64_t offset;
    std::shared_ptr<const FetchedGroup> fetched;
  };

  std::shared_ptr<const FetchedGroup> known_group(const FileRange& range);
  std::shared_ptr<const FetchedGroup> keep_group(const FileRange& range, Bytes bytes);

  const Manifest manifest_;
  const std::shared_ptr<const ContextTables> tables_;
  std::mutex mutex_;
  std::deque<Group> groups_;  ///< the newest first
};

}  // namespace pointreel
