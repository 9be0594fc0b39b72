#pragma once

#include <cstddef>
#include <string>

#include "pointreel/error.h"

namespace pointreel {

inline constexpr const char* kHardManifest = "manifest.json";

/// Writes all hard files and their manifest into a folder that is complete or absent; returns how
/// many files there are. With `force` a folder that holds nothing else is replaced.
Result<std::size_t> write_hard(const std::string& output, bool force);

}  // namespace pointreel
