#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "client/source/source.h"

namespace pointreel {

/// A folder of files of points, one file for each frame in natural order, or one such file;
/// recordings have many frames. It needs neither a server nor packing. Its manifest is made up: one
/// segment without layers, options.fps or the times of a recording, the axis that points up by the
/// format of the first file, or y where that does not tell or the files are turned, and the bounds
/// and attributes of the first frame that can be read and has points.
Result<std::unique_ptr<Source>> open_folder_source(const std::filesystem::path& path,
                                                   const SourceOptions& options);

/// The same of files from anywhere, in natural order of their names. At least one.
Result<std::unique_ptr<Source>> open_file_sequence(std::vector<std::filesystem::path> files,
                                                   const SourceOptions& options);

}  // namespace pointreel
