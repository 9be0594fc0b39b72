#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "server/pack/audio.h"

namespace pointreel {

struct JoinReport {
  std::uint32_t frames = 0, segments = 0;
  std::uint64_t bytes = 0;  ///< of all files of the package
  std::vector<std::string> warnings = {};
  std::optional<EncodedAudio> audio = {};  ///< the sound of the reel
};

/// Makes the package of the parts of a plan (plan.h), which is either complete or absent. Layer
/// files are linked, not copied, where the file system can. The folder of the parts is removed
/// afterwards. An error if segments are missing, which says where the first one begins; or if a
/// layer file has not the size that its manifest says. `force`: replace a package, whatever the
/// plan says.
Result<JoinReport> join_parts(const std::filesystem::path& output, bool force = false);

}  // namespace pointreel
