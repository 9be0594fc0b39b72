#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "pointreel/error.h"

namespace pointreel {

/// The view tokens of upstream servers. A file lists them: in each line the address of a server,
/// such as wss://HOST or ws://HOST:PORT, blanks, and its token. Empty lines, and those that begin
/// with #, count for nothing. A token is for one scheme, host and port: that of wss://HOST is never
/// sent to ws://HOST.
class UpstreamTokens {
 public:
  static constexpr std::size_t kMostBytes = 64u << 10;

  /// Errors name the line, and never what stands in the place of a token.
  static Result<UpstreamTokens> parse(std::string_view text);
  /// Errors begin with the path.
  static Result<UpstreamTokens> read(const std::filesystem::path& file);

  /// The token of the server with this address; null if there is none. `url` may have a path.
  const std::string* of(const std::string& url) const;

 private:
  std::map<std::string, std::string> tokens_;  ///< by scheme, host and port
};

}  // namespace pointreel
