#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "codec/files/recording.h"
#include "pointreel/error.h"

namespace pointreel {

/// Whether a folder has pictures of depth, `depth/*.png`. It may have other files as well.
bool is_depth_folder(const std::filesystem::path& folder);

/// The folder in which `folder` is the folder `depth`; empty if there is none.
std::filesystem::path capture_of_pictures(const std::filesystem::path& folder);

/// Where the pictures of such a folder are: those of depth, and those of colours if there are any.
std::vector<std::filesystem::path> picture_folders(const std::filesystem::path& folder);

/// Opens a folder as Open3D's tools and the TUM's data sets have it: `depth/*.png`, colours in
/// `color`, `rgb` or `image` (PNG or JPEG) if there are any, and intrinsics (depth_capture.h), with
/// names in letters of any case. Each frame is a depth_frame.
///
/// Names that are times tell when the pictures were taken: seconds with a fraction, or whole
/// numbers of 13, 16 or 19 digits, in milliseconds, microseconds or nanoseconds. Then the colours
/// of a frame are those that are nearest in time. Otherwise they are those of the same name, or
/// else of the same place in the natural order of the names, if no names are the same and there are
/// as many.
///
/// Errors begin with the folder or file: `invalid` if it cannot be told which pictures belong
/// together, or if none at all is within a second; `not_found`, `io`, and those of find_intrinsics.
///
/// Trust: names and files may be hostile. Opening takes memory for the names alone.
Result<std::shared_ptr<const Recording>> open_depth_folder(const std::filesystem::path& folder);

}  // namespace pointreel
