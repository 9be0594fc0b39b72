#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "pointreel/error.h"

namespace pointreel {

/// The tokens that servers ask viewers for. A file lists them: in each line the address of a
/// server, such as wss://HOST or http://HOST:PORT, blanks, and its token. Empty lines, and those
/// that begin with #, count for nothing. A token is for one host and port, with TLS or without:
/// that of wss://HOST is for https://HOST, too, and never sent to ws://HOST.
class ServerTokens {
 public:
  static constexpr std::size_t kMostBytes = 64u << 10;

  /// Errors name the line, and never what stands in the place of a token.
  static Result<ServerTokens> parse(std::string_view text);
  /// Errors begin with the path.
  static Result<ServerTokens> read(const std::filesystem::path& file);

  /// The token of the server with this address; null if there is none. `url` may have a path.
  const std::string* of(const std::string& url) const;

 private:
  std::map<std::string, std::string> tokens_;  ///< by host, port and whether there is TLS
};

}  // namespace pointreel
