#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "pointreel/error.h"

namespace pointreel {

/// Makes a folder that appears only once it is complete: `fill` writes into a folder beside
/// `output`, which is then moved to `output`. An existing folder is replaced only if it is empty,
/// or if `force` is set and `is_ours` accepts the name of every file in it.
Result<void> write_folder(const std::string& output, bool force,
                          const std::function<bool(std::string_view name)>& is_ours,
                          const std::function<Result<void>(const std::filesystem::path&)>& fill);

}  // namespace pointreel
