#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "pointreel/error.h"
#include "pointreel/package.h"
#include "server/store/package_files.h"

namespace pointreel {

/// From the first to the last, both included, among the frames that are shown.
struct CutRange {
  std::uint32_t first = 0, last = 0;
};

struct CutOptions {
  PackageFiles input;
  std::filesystem::path output;
  std::optional<CutRange> frames = {};  ///< which to keep; absent: those of the times
  /// Which to keep: all that are shown from one time of the reel, up to but not at another.
  std::uint64_t from_us = 0, to_us = UINT64_MAX;
  bool force = false;     ///< replace a package
  std::string name = {};  ///< of the new package; empty: that of its folder
};

struct CutReport {
  CutRange frames;  ///< that were kept, by their numbers in the old package
  std::uint32_t segments = 0;
  std::uint64_t bytes = 0;         ///< of all files of the new package
  std::optional<AudioFile> audio;  ///< of the new package
};

/// Makes a package of some frames of another one. The layer files of segments that are kept whole
/// are linked, or copied, as they are; of the segments at either end, the bytes of the frames that
/// are kept are copied. The new package begins at the time asked for, or with the first frame asked
/// for. Sound is cut at the same places, to the sample.
///
/// What the manifest says of all frames together, such as bounds and depths, it says of these, too.
/// Of a recording that still grows, what is there is taken.
///
/// Errors: `argument` for frames or times that the reel does not have; those of
/// PackageFiles::manifest, put_file, splice_sound and OutputFolder.
Result<CutReport> cut_package(const CutOptions& options, const std::stop_token& stop = {});

}  // namespace pointreel
