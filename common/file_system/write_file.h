#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

/// Why something cannot be written, by errno, and what to do. For people.
std::string why_not_written(int error);

/// Writes a file, replacing an existing one. If that fails, no part of the file stays. The error
/// (`io`) begins with the path.
Result<void> write_file(const std::filesystem::path& path, ByteView bytes);
Result<void> write_file(const std::filesystem::path& path, std::string_view text);

/// The same, but the existing file stays if that fails, and readers see either it or the new one.
Result<void> replace_file(const std::filesystem::path& path, ByteView bytes);
Result<void> replace_file(const std::filesystem::path& path, std::string_view text);

}  // namespace pointreel
