#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pointreel/error.h"

/// What folders of depth pictures and videos of depth have in common.
namespace pointreel {

/// The text of the first of these files that is there, to be read by parse_camera_intrinsics, with
/// which it has been checked. Errors begin with the file; if there is none, `not_found` says what
/// to put where.
Result<std::string> find_intrinsics(const std::vector<std::filesystem::path>& files);

/// What is assumed of a capture with these intrinsics, for Recording::guesses.
std::vector<std::string> guesses_of(std::string_view intrinsics);

/// "intrinsic.json" and the other names under which programs store intrinsics, in this folder.
std::vector<std::filesystem::path> intrinsics_in(const std::filesystem::path& folder);

/// For each of `times`, the one of `others` that is nearest to it. Both are in order and not empty.
std::vector<std::size_t> nearest_in_time(const std::vector<std::uint64_t>& times,
                                         const std::vector<std::uint64_t>& others);

}  // namespace pointreel
