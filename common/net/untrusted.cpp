#include "common/net/untrusted.h"

#include <fmt/format.h>

namespace pointreel {
namespace {

std::string advice_for(std::string_view said) {
  const auto has = [said](std::string_view part) { return said.find(part) != said.npos; };
  if (has("expired") || has("not yet valid")) return "renew it, or set the clock right";
  if (has("host name") || has("hostname") || has("IP address") || has("subject name")) {
    return "use a name that it was made for";
  }
  return "give its authority with --ca-file";
}

}  // namespace

Untrusted untrusted(std::string_view said) {
  return {fmt::format("the server's certificate is not trusted ({})", said), advice_for(said)};
}

}  // namespace pointreel
