#pragma once

#include <filesystem>
#include <string_view>

#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

/// Writes a file, replacing an existing one. The error (`io`) begins with the path.
Result<void> write_file(const std::filesystem::path& path, ByteView bytes);
Result<void> write_file(const std::filesystem::path& path, std::string_view text);

}  // namespace pointreel
