#include "common/command_line/token_option.h"

#include <cstdlib>

namespace pointreel {

std::string fault_of_token(cli::Option option) {
  const std::string variable = option.envname();
  const char* environment = variable.empty() ? nullptr : std::getenv(variable.c_str());
  std::string place = option.name();
  std::string token = "unset";
  if (option.count() > 0) {
    token = option.value();
  } else if (environment != nullptr) {
    place = variable;
    token = environment;
  }
  if (token.empty()) return place + ": is empty; give a token, or leave it out";
  for (const char c : token) {
    if (static_cast<unsigned char>(c) <= ' ' || c == 127) {
      return place + ": has a space or a control character, which no token may have";
    }
  }
  return {};
}

}  // namespace pointreel
