#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "pointreel/error.h"

namespace pointreel {

/// Makes a folder that appears only once it is complete (OutputFolder): `fill` writes its files. An
/// existing folder is replaced only if it is empty, or if `force` is set, it holds nothing but
/// files, and `is_ours` accepts the name of every one.
Result<void> write_folder(const std::string& output, bool force,
                          const std::function<bool(std::string_view name)>& is_ours,
                          const std::function<Result<void>(const std::filesystem::path&)>& fill);

}  // namespace pointreel
