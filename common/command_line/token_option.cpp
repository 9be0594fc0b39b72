#include "common/command_line/token_option.h"

#include <cstdlib>

#include "common/base/characters.h"

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
  if (!has_blank(token)) return {};
  return place + ": has a blank or a control character, which no token may have";
}

}  // namespace pointreel
