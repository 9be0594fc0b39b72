#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "pointreel/error.h"
#include "server/relay/relay.h"
#include "server/serve/live_resources.h"
#include "server/serve/resource.h"

/// What the server serves: a table from decoded URL paths to resources, which is made once at the
/// start from the manifests of the packages, and beside it the resources of live streams. Nothing
/// outside these tables can be reached, whatever a request says.
namespace pointreel {

enum class OpenError {
  kChanged,  ///< the file is gone, or has another content
  kBusy,     ///< no file descriptor is free at present
};

/// The file of a kFile resource, opened unless it is open already. If it is not the file that the
/// table was made of, or was touched since, its content is compared with the checksum, once.
tl::expected<SharedFile, OpenError> open_resource(const Resource& resource);

/// The folders of packages that these folders stand for: a folder without a manifest stands for the
/// packages in it, in natural order of their names, without those that are hidden. Any other folder
/// stands for itself, so that Catalog::load says what is wrong with it.
std::vector<std::filesystem::path> packages_in(const std::vector<std::filesystem::path>& folders);

class Catalog {
 public:
  /// Reads the manifests and checks that every file that they name exists, has the right size and
  /// lies in its package. The paths are:
  ///   /healthz            "ok"
  ///   /NAME, /NAME/       redirects to the manifest
  ///   /NAME/reel.json     the manifest as it is on disk now
  ///   /NAME/FILE          each file that the manifest names
  /// where NAME is the name of the folder. It is an error if a folder is not a package, if a
  /// package is incomplete, if two folders have the same name, or if a symbolic link leads out of a
  /// package.
  static Result<Catalog> load(const std::vector<std::filesystem::path>& folders);

  /// Adds the resources of live streams, which are looked up after those of packages. Call this
  /// before the catalog is served.
  void add(std::shared_ptr<const LiveResources> live) { live_ = std::move(live); }

  /// The list of the packages and of these streams, JSON, which is served at /. From any thread.
  std::shared_ptr<const Resource> list(const std::vector<StreamStatistics>& streams) const;

  /// The resource at a decoded path; null if there is none. From any thread.
  std::shared_ptr<const Resource> find(std::string_view path) const;

 private:
  ResourceTable resources_;
  std::string packages_ = "[]";  ///< JSON
  std::shared_ptr<const LiveResources> live_;
};

}  // namespace pointreel
