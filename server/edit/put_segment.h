#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "pointreel/package.h"
#include "server/store/package_files.h"

/// What cut_package and join_packages share.
namespace pointreel {

/// Puts a file of one package into the folder of another, which has the same bytes under its name.
/// Errors begin with the file: `io`, or `invalid` if it has not the size that the manifest says.
Result<void> put_file(const PackageFiles& from, const PackageFile& file,
                      const std::filesystem::path& folder, const std::string& name);

/// Puts the files of a segment into the folder of another package. `segment` is that of the new
/// package, but for the names of its files, which are made anew: they begin with the number of its
/// first frame. The sound of a live stream is left out.
Result<void> put_segment(const PackageFiles& from, const std::filesystem::path& folder,
                         const std::vector<std::string>& layer_names, Segment& segment);

/// The same, if `segment` has only some frames of the `whole` one in the old package, from the one
/// with index `begin` on: their bytes are copied. Errors: also `invalid` if the old file has not
/// the checksum that the manifest says.
Result<void> put_frames(const PackageFiles& from, const std::filesystem::path& folder,
                        const std::vector<std::string>& layer_names, const Segment& whole,
                        std::uint32_t begin, Segment& segment);

}  // namespace pointreel
