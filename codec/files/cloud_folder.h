#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pointreel/error.h"

/// Which files of a folder are frames.
namespace pointreel {

/// Whether files of that name may hold points, in small letters or capitals.
bool is_cloud_file(const std::filesystem::path& path);
/// Whether list_cloud_files finds something in this folder.
bool has_cloud_files(const std::filesystem::path& folder);

/// The files that `inputs` name, in order: a folder stands for its files of points in natural order
/// (frame2 before frame10), a file for itself. Where a folder has files that are clearly of points,
/// those that may be something else (.txt, .csv, .bin, .mkv) do not count, and text with a name
/// such as calib.txt never does. Of several formats, only the commonest counts, or else recordings;
/// `warnings` receives a line about the others. A folder with pictures of depth (depth_folder.h),
/// and no files that are clearly of points, stands for itself. Fails if there are none, and if two
/// formats have as many files.
Result<std::vector<std::filesystem::path>> list_cloud_files(
    const std::vector<std::filesystem::path>& inputs, std::vector<std::string>* warnings = nullptr);

}  // namespace pointreel
