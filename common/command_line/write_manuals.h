#pragma once

#include <filesystem>

#include <CLI/CLI.hpp>

#include "pointreel/error.h"

namespace pointreel {

/// Writes what tells people and shells about a program, made of its table of options, where systems
/// look for it below /usr/share or ~/.local/share: a manual page for the program and one for each
/// command in man/man1, and completions in bash-completion/completions, zsh/vendor-completions and
/// fish/vendor_completions.d.
Result<void> write_manuals(const CLI::App& program, const std::filesystem::path& folder);

}  // namespace pointreel
