#pragma once

#include <filesystem>

namespace pointreel {

/// Pointreel's own folder among the user's files of a kind, by the XDG Base Directory
/// Specification: in the folder that the environment variable names, such as XDG_STATE_HOME, or
/// else in `below_home`, such as ".local/state". Empty if the user has neither.
std::filesystem::path user_folder(const char* variable, const char* below_home);

}  // namespace pointreel
