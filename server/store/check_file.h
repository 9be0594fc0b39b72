#pragma once

#include <filesystem>

#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// Whether a file of a package has the size that the manifest says. Errors do not name the file.
Result<void> check_size(const std::filesystem::path& path, const PackageFile& file);

/// Whether it has the checksum that the manifest says. Reads all of it.
Result<void> check_checksum(const std::filesystem::path& path, const PackageFile& file);

}  // namespace pointreel
