#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>

namespace pointreel {

/// Something that can be fetched: a text, or a file that is opened for each request, so that
/// packages need no descriptors while nobody fetches them.
struct Resource {
  enum class Kind { kText, kFile, kRedirect };
  Kind kind = Kind::kText;
  std::string content_type;
  std::string cache_control;
  std::string etag;              ///< strong; empty if there is none
  std::string text;              ///< kText: the content; kRedirect: the Location
  std::filesystem::path file;    ///< kFile: canonical, without symbolic links
  std::uint64_t size = 0;        ///< bytes of the content
  std::int64_t modified_ns = 0;  ///< kFile: the modification time when the table was made
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
