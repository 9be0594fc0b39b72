#pragma once

#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "client/source/source.h"

namespace pointreel {

/// An error of reading a manifest, for who may have named something that is no package at all.
Error no_package(const Error& error);

/// A package, wherever its files are: fetches what is wanted of a frame, all of it at once.
class PackageSource : public Source {
 public:
  const Manifest& manifest() const final { return manifest_; }
  Result<FetchedFrame> fetch(const FetchRequest& request) final;

 protected:
  PackageSource(Manifest manifest, std::shared_ptr<const ContextTables> tables);

  /// The bytes of each range, none of which is empty: exactly as many. The error names the file.
  virtual Result<std::vector<Bytes>> read(std::span<const FileRange> ranges,
                                          const FetchRequest& request) = 0;

 private:
  const Manifest manifest_;
  const std::shared_ptr<const ContextTables> tables_;
};

}  // namespace pointreel
