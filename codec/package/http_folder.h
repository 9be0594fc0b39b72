#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/http/aws_access.h"
#include "pointreel/error.h"

namespace pointreel {

/// The address of a package or live stream, from which its files are fetched.
struct HttpFolder {
  std::string base;   ///< without a slash at the end
  std::string query;  ///< with its question mark, or empty
  /// What requests are signed with, if it is a folder of an object store.
  std::optional<AwsAccess> access = {};

  /// The address of a file. It has the query too: signed addresses are valid only with it.
  std::string file(const std::string& path) const { return base + "/" + path + query; }
  std::string manifest() const;
};

/// Whether it is an address such as s3://BUCKET/REEL.
bool is_store_address(std::string_view text);
/// Whether HttpFolder can be made of it: http, https or s3.
bool is_folder_address(std::string_view text);

/// The folder that an address names, or whose reel.json it names. A fragment is left out. Errors:
/// as parse_url.
Result<HttpFolder> parse_http_folder(const std::string& url);

/// The folder s3://BUCKET/KEY of a store. KEY is as the store has it, not percent-encoded. Errors:
/// `argument` for a bucket or a key that no store has, or that would not survive the way there.
Result<HttpFolder> parse_store_folder(const std::string& address, const Store& store);

/// The folder of either kind. `endpoint`: as in resolve_store, whose errors this has, after the
/// address.
Result<HttpFolder> resolve_folder(const std::string& address, const std::string& endpoint);

}  // namespace pointreel
