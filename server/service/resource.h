#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

namespace pointreel {

/// What tells a file on disk from one that was put in its place, or written over it. The time of
/// the last change of its attributes (`changed_ns`) cannot be set back, unlike that of the content.
struct FileIdentity {
  std::uint64_t device = 0, inode = 0, size = 0;
  std::int64_t modified_ns = 0, changed_ns = 0;
  bool operator==(const FileIdentity&) const = default;
};

/// An open file, which is closed with its last owner.
class FileHandle {
 public:
  explicit FileHandle(int descriptor) : descriptor_(descriptor) {}
  FileHandle(const FileHandle&) = delete;
  FileHandle& operator=(const FileHandle&) = delete;
  ~FileHandle();
  int get() const { return descriptor_; }

 private:
  const int descriptor_;
};
using SharedFile = std::shared_ptr<const FileHandle>;

/// What is known about the file of a resource, for all threads that serve it.
struct KnownFile {
  std::mutex mutex;                      // guards what follows
  FileIdentity right;                    ///< known to have the right content
  std::optional<FileIdentity> wrong;     ///< known to have another
  std::weak_ptr<const FileHandle> open;  ///< while a response or a connection holds it
};

/// Something that can be fetched: a text, or a file that is open only while somebody fetches it, so
/// that packages need no descriptors otherwise.
struct Resource {
  enum class Kind { kText, kFile, kRedirect };
  Kind kind = Kind::kText;
  std::string content_type;
  std::string cache_control;
  std::string etag;                  ///< strong; empty if there is none
  std::string fields;                ///< further header lines, each ending in CRLF
  std::string text;                  ///< kText: the content; kRedirect: the Location
  std::filesystem::path file;        ///< kFile: canonical, without symbolic links
  std::uint64_t size = 0;            ///< bytes of the content
  std::uint64_t checksum = 0;        ///< kFile: `checksum_of` the content
  std::shared_ptr<KnownFile> known;  ///< kFile: not null
};

/// The Cache-Control of resources that may change: caches must ask again each time, with the entity
/// tag.
inline constexpr const char* kRevalidate = "no-cache";
/// The Cache-Control of files that never change under their name.
inline constexpr const char* kImmutable = "public, max-age=31536000, immutable";

/// A kText resource with its size and entity tag.
Resource text_resource(std::string content_type, std::string cache_control, std::string text);
/// `location` is percent-encoded.
Resource redirect_resource(std::string location);

struct PathHash {
  using is_transparent = void;
  std::size_t operator()(std::string_view text) const {
    return std::hash<std::string_view>{}(text);
  }
};
/// Resources by decoded URL paths.
using ResourceTable =
    std::unordered_map<std::string, std::shared_ptr<const Resource>, PathHash, std::equal_to<>>;

}  // namespace pointreel
