#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "pointreel/error.h"
#include "server/relay/relay.h"
#include "server/service/live_resources.h"
#include "server/service/resource.h"

/// What the server serves: a table from decoded URL paths to resources, which is made of the
/// manifests of the packages, and beside it the resources of live streams. Nothing outside these
/// tables can be reached, whatever a request says.
namespace pointreel {

enum class OpenError {
  kChanged,  ///< the file is gone, or has another content
  kBusy,     ///< no file descriptor is free at present
};

/// The file of a kFile resource, opened unless it is open already. If it is not the file that the
/// table was made of, or was touched since, its content is compared with the checksum, once.
tl::expected<SharedFile, OpenError> open_resource(const Resource& resource);

/// A folder with a package, and the name under which it is served: one segment of a path or more.
struct PackageFolder {
  std::filesystem::path folder;
  std::string name;
  bool found = false;  ///< in a folder that stands for its packages
};

/// The most folders that are looked into, and how deep, so that looking takes a bounded time.
inline constexpr std::size_t kMaxFolders = 100'000;
inline constexpr int kMaxFolderDepth = 8;

/// The packages that these folders stand for. A folder with a manifest stands for itself, by its
/// own name. Any other stands for the packages in it and in its folders, by their paths in it, in
/// natural order, without what is hidden or in a folder named `live` or `page`, and without
/// following symbolic links to folders that are no packages. A folder that holds files but no
/// packages stands for itself, too, so that Catalog::load says what is wrong with it.
Result<std::vector<PackageFolder>> packages_in(const std::vector<std::filesystem::path>& folders);

/// Copies share their content. Any thread may call anything, but only one at a time `refresh`.
class Catalog {
 public:
  Catalog();

  /// Reads the manifests and checks that every file that they name exists, has the right size and
  /// lies in its package. The paths are:
  ///   /healthz            "ok"
  ///   /NAME, /NAME/       redirects to the manifest
  ///   /NAME/reel.json     the manifest as it is on disk now
  ///   /NAME/FILE          each file that the manifest names
  /// where NAME is the name of the package. It is an error if a folder is not a package, if a
  /// package is incomplete, if two have the same name, or if a symbolic link leads out of a
  /// package. Packages that were found in a folder, and have such faults, are left to `refresh`.
  static Result<Catalog> load(const std::vector<std::filesystem::path>& folders);

  /// Takes in packages that have appeared or changed since, and leaves out those that have gone or
  /// are no longer valid. Returns a line for each package that has come or gone, and for each
  /// fault, once for as long as it lasts.
  struct News {
    std::vector<std::string> changes, faults;
  };
  News refresh(const std::vector<std::filesystem::path>& folders);

  /// Adds the resources of live streams, which are looked up after those of packages. Call this
  /// before the catalog is served.
  void add(std::shared_ptr<const LiveResources> live);

  /// The list of the packages and of these streams, JSON, which is served at /. It is made anew at
  /// most ten times a second, however often it is asked for; until then `streams` is not called.
  /// It may be empty: there are none.
  std::shared_ptr<const Resource> list(
      const std::function<std::vector<StreamStatistics>()>& streams) const;

  /// The resource at a decoded path; null if there is none.
  std::shared_ptr<const Resource> find(std::string_view path) const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace pointreel
