#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <sys/types.h>

#include "pointreel/error.h"

namespace pointreel {

/// Debian's nginx, which runs in the background with a folder of its own until it is destroyed.
class Nginx {
 public:
  /// Whether nginx is installed on this machine.
  static bool installed();

  /// Starts nginx. `http` returns the content of the http block for a port at 127.0.0.1 that nginx
  /// should listen on. Returns when nginx accepts connections; fails if it ends instead.
  static Result<std::unique_ptr<Nginx>> start(
      const std::filesystem::path& folder,
      const std::function<std::string(std::uint16_t port)>& http);
  ~Nginx();
  Nginx(const Nginx&) = delete;
  Nginx& operator=(const Nginx&) = delete;

  std::uint16_t port() const { return port_; }

 private:
  Nginx(pid_t pid, std::uint16_t port) : pid_(pid), port_(port) {}
  pid_t pid_;
  std::uint16_t port_;
};

/// The configuration server/nginx/NAME with the first text of each pair, which must occur in it,
/// replaced by the second.
std::string nginx_configuration(
    const std::string& name, const std::vector<std::pair<std::string, std::string>>& replacements);

}  // namespace pointreel
