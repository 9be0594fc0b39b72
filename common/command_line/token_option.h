#pragma once

#include <string>

#include "common/command_line/command.h"

namespace pointreel {

/// What is wrong with the value of an option for a token, on the command line, in a configuration
/// file or in the environment; empty if nothing. Somebody who sets a token to nothing, as in
/// "--token $UNSET", does not mean that none is needed.
std::string fault_of_token(cli::Option option);

}  // namespace pointreel
