#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>

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

/// What is asked for each time, with the entity tag, for it may change.
inline constexpr const char* kRevalidate = "no-cache";
/// What never changes under its name.
inline constexpr const char* kImmutable = "public, max-age=31536000, immutable";

/// A kText resource with its size and entity tag.
Resource text_resource(std::string content_type, std::string cache_control, std::string text);
/// `location` as it stands in a response: percent-encoded.
Resource redirect_resource(std::string location);

struct PathHash {
  using is_transparent = void;
  std::size_t operator()(std::string_view text) const {
    return std::hash<std::string_view>{}(text);
  }
};
/// From decoded URL paths.
using ResourceTable =
    std::unordered_map<std::string, std::shared_ptr<const Resource>, PathHash, std::equal_to<>>;

}  // namespace pointreel
