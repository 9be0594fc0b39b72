#include "common/net/untrusted.h"

#include <cerrno>
#include <system_error>

#include <fmt/format.h>
#include <unistd.h>

namespace pointreel {
namespace {

std::string advice_for(std::string_view said, std::string_view ca_option) {
  const auto has = [said](std::string_view part) { return said.find(part) != said.npos; };
  if (has("expired") || has("not yet valid")) return "renew it, or set the clock right";
  if (has("host name") || has("hostname") || has("IP address") || has("subject name")) {
    return "use a name that it was made for";
  }
  return fmt::format("give its authority with {}", ca_option);
}

}  // namespace

Untrusted untrusted(std::string_view said, std::string_view ca_option) {
  return {fmt::format("the server's certificate is not trusted ({})", said),
          advice_for(said, ca_option)};
}

std::string fault_of_certificates(const std::string& file) {
  if (::access(file.c_str(), R_OK) == 0) return file + ": holds no certificates in PEM form";
  return fmt::format("{}: {}", file, std::generic_category().message(errno));
}

}  // namespace pointreel
