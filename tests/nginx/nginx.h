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

/// Debian's nginx in the background, in a folder of its own, ended by the destructor.
class Nginx {
 public:
  /// Whether there is one on this machine.
  static bool installed();

  /// `http` gives what is to stand in the http block, for the port that nginx is to listen on, at
  /// 127.0.0.1. Returns when nginx accepts connections; an error if it ends instead.
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

/// One of our configurations (server/nginx/NAME), with the text `from` in it, which must be there,
/// replaced by `to` for each pair.
std::string nginx_configuration(
    const std::string& name, const std::vector<std::pair<std::string, std::string>>& replacements);

}  // namespace pointreel
