#pragma once

#include <cstddef>
#include <string>

#include "pointreel/error.h"

namespace pointreel {

inline constexpr const char* kHardManifest = "manifest.json";

/// Writes all hard files and their manifest into a folder that appears only once it is complete,
/// and returns the number of files. With `force`, a folder that holds only such files is replaced.
Result<std::size_t> write_hard(const std::string& output, bool force);

}  // namespace pointreel
