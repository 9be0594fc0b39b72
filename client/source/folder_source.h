#pragma once

#include <filesystem>
#include <memory>

#include "client/source/source.h"

namespace pointreel {

/// A folder of PLY and .drc files, one a frame in natural order, or one such file; no server and no
/// packing. The manifest is made up: one segment without layers, options.fps and options.up, bounds
/// and attributes of the first frame that can be read and has points.
Result<std::unique_ptr<Source>> open_folder_source(const std::filesystem::path& path,
                                                   const SourceOptions& options);

}  // namespace pointreel
