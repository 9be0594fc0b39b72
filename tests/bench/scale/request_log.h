#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "pointreel/error.h"

namespace pointreel::bench {

/// A request for some frames of a layer of a package.
struct LoggedRequest {
  double seconds = 0.0;       ///< since the first request of the log
  std::uint32_t segment = 0;  ///< counted from 0
  std::uint32_t layer = 0;    ///< 0 is the coarsest
  std::uint64_t bytes = 0;    ///< of the answer
};

/// The requests for layer files in what `pointreel-server serve --log info` wrote while one viewer
/// played one package, whose first segment must be among them. The names of layers must be those
/// that `pack` gives by default. Other lines are skipped.
Result<std::vector<LoggedRequest>> read_request_log(const std::filesystem::path& file);

}  // namespace pointreel::bench
