#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>

#include "server/service/resource.h"

namespace pointreel {

/// A file of the page that plays reels in a browser, in each form in which it is sent. Its name is
/// "index.html", or relative to the folder of all others, such as "5C2Q7XNA/player.js".
struct PageFile {
  std::string_view name;
  std::string_view plain, brotli, gzip;
};

/// The page that plays reels in a browser, as resources. The page itself, `index.html`, changes
/// with the program. All other files lie in a folder that is named after their hash, and never
/// change.
class Page {
 public:
  /// No page.
  Page() = default;
  /// The memory of `files` must stay valid. `frame_ancestors`: see parse_frame_ancestors.
  explicit Page(std::span<const PageFile> files, std::string_view frame_ancestors = "'self'");

  bool empty() const { return start_ == nullptr; }

  /// The page itself. `accept_encoding`: the untrusted value of that header field.
  std::shared_ptr<const Resource> start(std::string_view accept_encoding) const;

  /// A file that the page loads: /page/NAME. It is also found below folders, since the page itself
  /// is served at /live/NAME and at FOLDER/REEL, too, and names its files relative to that. Null if
  /// there is none.
  std::shared_ptr<const Resource> find(std::string_view path,
                                       std::string_view accept_encoding) const;

 private:
  struct Forms {
    std::shared_ptr<const Resource> plain, brotli, gzip;
  };
  static const std::shared_ptr<const Resource>& best(const Forms& forms,
                                                     std::string_view accept_encoding);
  static std::shared_ptr<const Forms> forms_of(const PageFile& file,
                                               std::string_view frame_ancestors);

  std::shared_ptr<const Forms> start_;
  std::unordered_map<std::string, std::shared_ptr<const Forms>, PathHash, std::equal_to<>> files_;
};

}  // namespace pointreel
