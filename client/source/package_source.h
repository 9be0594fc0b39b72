#pragma once

#include <memory>
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
  const Manifest manifest_;
  const std::shared_ptr<const ContextTables> tables_;
};

}  // namespace pointreel
