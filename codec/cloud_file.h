#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "codec/formats/cloud_format.h"
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
  std::vector<std::string> unread;    ///< names of what points have in the file and was skipped
};

/// For files that a user chose to encode: with as many points as a frame may have, whatever memory
/// that takes.
inline const DecodeLimits kOwnFiles{.max_memory = ~std::uint64_t{0}};

/// Reads the points of a file of any format (cloud_format.h), which may also be a mesh. The error
/// does not contain the file's name.
///
/// `limits` holds where few bytes may stand for many points, as in Draco.
///
/// Trust: the bytes may be hostile. Memory is bounded by their number, and by `limits`.
Result<LoadedCloud> read_cloud(ByteView bytes, CloudFormat format,
                               const DecodeLimits& limits = kOwnFiles);
/// The same for formats that are recognised by their first bytes.
Result<LoadedCloud> read_cloud(ByteView bytes, const DecodeLimits& limits = kOwnFiles);

/// The cloud as read_cloud returns it: sanitized, and with what was repaired.
LoadedCloud usable_cloud(PointCloud cloud, CloudFormat format);

/// Reads a file. Its format is recognised by its first bytes, or else by its name. The error begins
/// with the path.
Result<LoadedCloud> read_cloud_file(const std::filesystem::path& path,
                                    const DecodeLimits& limits = kOwnFiles);

/// Whether files of that name may hold points, in small letters or capitals.
bool is_cloud_file(const std::filesystem::path& path);

/// The files that `inputs` name, in order: a folder stands for its files of points in natural order
/// (frame2 before frame10), a file for itself. Where a folder has files that are clearly of points,
/// those that may be something else (.txt, .csv, .bin) do not count. Fails if there are none.
Result<std::vector<std::filesystem::path>> list_cloud_files(
    const std::vector<std::filesystem::path>& inputs);

/// The axis that points up in a file by its format, 'y' or 'z'; nothing if that does not tell.
std::optional<char> up_of_file(const std::filesystem::path& path);

}  // namespace pointreel
