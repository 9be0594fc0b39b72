#pragma once

#include <string>

#include "common/command_line/command_table.h"

namespace pointreel::cli {

/// "pointreel-server-pack-plan": the name of the manual page of a command.
std::string manual_name(const CommandEntry& command);

/// The manual page of a command, for section 1, in the language of man(7). It says what --help
/// says.
std::string manual_page(const CommandEntry& command);

}  // namespace pointreel::cli
