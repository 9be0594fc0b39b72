#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

namespace pointreel {

/// A cloud from a file that is safe to use (see `sanitize`; unusable radii are estimated), and what
/// was repaired for that.
struct LoadedCloud {
  PointCloud cloud;
  std::vector<std::string> warnings;  ///< lines without the file's name
  std::vector<std::string> unread;  ///< names of scalar properties of a PLY file that were skipped
};

/// For files that a user chose to encode: with as many points as a frame may have, whatever memory
/// that takes.
inline const DecodeLimits kOwnFiles{.max_memory = ~std::uint64_t{0}};

/// Reads the points of a .ply or .drc file, which may also be a mesh. The format is recognised by
/// the file's first bytes, not by its name. The error does not contain the file's name.
///
/// `limits` holds for Draco, where few bytes may stand for many points.
///
/// Trust: the bytes may be hostile. Memory is bounded by their number, and by `limits`.
Result<LoadedCloud> read_cloud(ByteView bytes, const DecodeLimits& limits = kOwnFiles);

/// Reads a file. The error begins with the path.
Result<LoadedCloud> read_cloud_file(const std::filesystem::path& path,
                                    const DecodeLimits& limits = kOwnFiles);

/// Whether the name is that of a .ply or .drc file, in small letters or capitals.
bool is_cloud_file(const std::filesystem::path& path);

/// The files that `inputs` name, in order: a folder stands for its .ply and .drc files in natural
/// order (frame2 before frame10), a file for itself. Fails if there are none.
Result<std::vector<std::filesystem::path>> list_cloud_files(
    const std::vector<std::filesystem::path>& inputs);

}  // namespace pointreel
