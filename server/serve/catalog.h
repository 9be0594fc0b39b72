#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pointreel/error.h"
#include "server/serve/live_resources.h"
#include "server/serve/resource.h"

/// What the server serves: a table from decoded URL paths to resources, made once, at the start,
/// from the packages' manifests; and what live streams put beside it. Nothing outside the tables
/// can be reached, whatever a request says.
namespace pointreel {

/// An open file descriptor with one owner.
class FileHandle {
 public:
  FileHandle() = default;
  explicit FileHandle(int descriptor) : descriptor_(descriptor) {}
  FileHandle(FileHandle&& other) noexcept : descriptor_(other.descriptor_) {
    other.descriptor_ = -1;
  }
  FileHandle& operator=(FileHandle&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~FileHandle();
  int get() const { return descriptor_; }

 private:
  int descriptor_ = -1;
};

enum class OpenError {
  kChanged,  ///< vanished, or its size or time of modification is not what it was
  kBusy,     ///< no descriptor is free now
};

/// Opens a kFile resource if it is still the file that the table was made from.
tl::expected<FileHandle, OpenError> open_resource(const Resource& resource);

class Catalog {
 public:
  /// Reads the manifests and checks that every file they name is there, has its size and lies in
  /// its package. Paths:
  ///   /                   listing of the packages, JSON
  ///   /healthz            "ok"
  ///   /NAME, /NAME/       redirects to the manifest
  ///   /NAME/reel.json     the manifest as it is on disk now
  ///   /NAME/FILE          each file that the manifest names
  /// NAME is the folder's name. Errors: a folder that is no package, an incomplete package, two
  /// folders of one name, a symbolic link that leads out of its package.
  static Result<Catalog> load(const std::vector<std::filesystem::path>& folders);

  /// From now on what live streams have counts too, behind what packages have. Before it is served.
  void add(std::shared_ptr<const LiveResources> live) { live_ = std::move(live); }

  /// By decoded path; null if there is no such resource. From any thread.
  std::shared_ptr<const Resource> find(std::string_view path) const;

 private:
  ResourceTable resources_;
  std::shared_ptr<const LiveResources> live_;
};

}  // namespace pointreel
