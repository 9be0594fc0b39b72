#pragma once

#include <string>

#include "pointreel/error.h"

namespace pointreel {

/// The address of a package or live stream, from which its files are fetched.
struct HttpFolder {
  std::string base;   ///< without a slash at the end
  std::string query;  ///< with its question mark, or empty

  /// The address of a file. It has the query too: signed addresses are valid only with it.
  std::string file(const std::string& path) const { return base + "/" + path + query; }
  std::string manifest() const;
};

/// The folder that an address names, or whose reel.json it names. A fragment is left out. Errors:
/// as parse_url.
Result<HttpFolder> parse_http_folder(const std::string& url);

}  // namespace pointreel
