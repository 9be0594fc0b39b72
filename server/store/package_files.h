#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "common/http/http_options.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// The files of a package, wherever they are: in a folder, or at an address, http:// or s3://, from
/// which each is fetched when it is first asked for. Fetched files lie in a folder for temporary
/// files, which goes with the last copy of this object.
class PackageFiles {
 public:
  /// Those of a folder.
  PackageFiles(std::filesystem::path folder = {}) : folder_(std::move(folder)) {}
  /// `where`: a folder, or an address as resolve_folder takes it. `options` say how to fetch.
  /// Errors: as resolve_folder.
  static Result<PackageFiles> at(const std::string& where, const HttpOptions& options);

  bool remote() const { return remote_ != nullptr; }

  /// Reads the manifest, and the journal beside it in a folder. Errors: as read_manifest, or as
  /// HttpClient.
  Result<Manifest> manifest() const;

  /// Where a file that the manifest names is on this machine. It need not be there in a folder; a
  /// fetched one has the size that the manifest says. May be called by many threads at once.
  ///
  /// Trust: the server may be hostile. No more is fetched than the manifest says, and memory is
  /// bounded.
  Result<std::filesystem::path> local(const PackageFile& file) const;

  /// Why fetched files cannot be kept on this machine, if some could not; the package may be good.
  std::optional<Error> lacks_room() const;

  /// The package, or a file of it, for people.
  std::string shown() const;
  std::string shown(const PackageFile& file) const;

 private:
  class Remote;
  std::filesystem::path folder_;
  std::shared_ptr<Remote> remote_;
};

}  // namespace pointreel
