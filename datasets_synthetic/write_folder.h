#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "pointreel/error.h"

namespace pointreel {

/// Makes a folder that is complete or absent: `fill` writes into a folder beside `output`, which
/// then moves to its place. What is at `output` already is replaced only if it is an empty folder,
/// or if `force` is set and it holds nothing but files that `is_ours` knows by name; and only once
/// all is written.
Result<void> write_folder(const std::string& output, bool force,
                          const std::function<bool(std::string_view name)>& is_ours,
                          const std::function<Result<void>(const std::filesystem::path&)>& fill);

}  // namespace pointreel
