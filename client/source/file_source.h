#pragma once

#include <filesystem>
#include <memory>

#include "client/source/source.h"

namespace pointreel {

/// A package in a local folder.
Result<std::unique_ptr<Source>> open_file_source(const std::filesystem::path& folder);

}  // namespace pointreel
