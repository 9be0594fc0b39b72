#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// A cloud from a file, fit for use (see `sanitize`; unusable radii estimated), and what had to be
/// mended to make it so.
struct LoadedCloud {
  PointCloud cloud;
  std::vector<std::string> warnings;  ///< one line each, without the file's name
};

/// Reads a .ply or .drc file (point cloud or mesh: its vertices), told apart by its first bytes,
/// not its name. The error does not repeat the file's name.
///
/// Trust: the bytes may be hostile; memory is bounded by them, for meshes of Draco's as
/// drc_reader.h says.
Result<LoadedCloud> read_cloud(ByteView bytes);

/// The same from a path; the error begins with it.
Result<LoadedCloud> read_cloud_file(const std::filesystem::path& path);

/// The frames that `inputs` name, in order: each folder gives its .ply and .drc files in natural
/// order (frame2 before frame10), each file itself. An error if that is none.
Result<std::vector<std::filesystem::path>> list_cloud_files(
    const std::vector<std::filesystem::path>& inputs);

}  // namespace pointreel
