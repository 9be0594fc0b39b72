#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "common/base/error.h"

/// What the server serves: a table from decoded URL paths to resources, made once, at the start,
/// from the packages' manifests. Nothing outside the table can be reached, whatever a request says.
namespace pointreel {

/// One thing that can be fetched. Either `text`, or a file that is opened for each request, so
/// that a package of any number of files needs no descriptors while nobody asks.
struct Resource {
  enum class Kind { kText, kFile, kRedirect };
  Kind kind = Kind::kText;
  std::string content_type;
  std::string cache_control;
  std::string etag;              ///< strong; empty if there is none
  std::string text;              ///< kText: the content; kRedirect: the Location
  std::filesystem::path file;    ///< kFile: canonical, without symbolic links
  std::uint64_t size = 0;        ///< bytes of the content
  std::int64_t modified_ns = 0;  ///< kFile: time of modification when the table was made
};

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

  /// By decoded path; null if there is no such resource.
  const Resource* find(std::string_view path) const;

 private:
  struct Hash {
    using is_transparent = void;
    std::size_t operator()(std::string_view text) const {
      return std::hash<std::string_view>{}(text);
    }
  };
  std::unordered_map<std::string, Resource, Hash, std::equal_to<>> resources_;
};

}  // namespace pointreel
