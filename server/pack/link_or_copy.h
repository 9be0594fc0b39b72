#pragma once

#include <filesystem>

#include "pointreel/error.h"

namespace pointreel {

/// Gives a file that never changes a second name or, where the file system cannot, copies it.
/// Errors: `io`, which begin with the first path.
Result<void> link_or_copy(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace pointreel
