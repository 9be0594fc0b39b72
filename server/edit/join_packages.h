#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "pointreel/package.h"
#include "server/store/package_files.h"

namespace pointreel {

struct JoinOptions {
  std::vector<PackageFiles> inputs;  ///< at least one, in the order in which they are shown
  std::filesystem::path output;
  bool force = false;     ///< replace a package
  std::string name = {};  ///< of the new package; empty: that of its folder
};

struct JoinedPackages {
  std::uint32_t frames = 0, segments = 0;
  std::uint64_t bytes = 0;          ///< of all files of the new package
  std::optional<AudioFile> audio;   ///< of the new package
  std::vector<std::size_t> silent;  ///< the inputs that have no sound, if any has
};

/// Makes one package of several, such as recordings of the same stream. Layer files are linked, or
/// copied, as they are. Each package begins when the one before it is over: a pause between two
/// recordings is left out. `captured_us` is that of the first. The name is that of the first. Sound
/// is where it was; splice_sound says how exactly.
///
/// Of a recording that still grows, what is there is taken.
///
/// Errors: `argument` for packages that do not go together, because they differ in what
/// append_manifest says, in the frame rate or, where both have points, in the attributes of points;
/// `limit` if the manifest or the sound gets too long; those of PackageFiles::manifest, put_file,
/// splice_sound and OutputFolder.
Result<JoinedPackages> join_packages(const JoinOptions& options, const std::stop_token& stop = {});

}  // namespace pointreel
