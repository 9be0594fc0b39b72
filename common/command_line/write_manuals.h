#pragma once

#include <filesystem>
#include <vector>

#include "common/command_line/command_table.h"
#include "pointreel/error.h"

namespace pointreel::cli {

/// Writes what tells people and shells about a program, made of its table of commands, the
/// first of which is the program, where systems look for it below /usr/share or ~/.local/share: a
/// manual page for the program and one for each command in man/man1, and completions in
/// bash-completion/completions, zsh/vendor-completions and fish/vendor_completions.d.
Result<void> write_manuals(const std::vector<CommandEntry>& commands,
                           const std::filesystem::path& folder);

}  // namespace pointreel::cli
