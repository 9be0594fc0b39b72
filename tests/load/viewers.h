#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "tests/load/crowd.h"
#include "tests/load/load_figures.h"

namespace pointreel {

/// No answer of our server has a longer head.
inline constexpr std::size_t kMaxHead = 4096;

/// The requests for the frames of a package, written once for all viewers.
struct PackageRequests {
  struct Frame {
    std::chrono::microseconds due{0};  ///< since the start of the loop
    unsigned layers = 0;
    std::string requests;
  };
  std::vector<Frame> frames;
  std::chrono::microseconds loop{0};
};
Result<std::shared_ptr<const PackageRequests>> package_requests(const LoadOptions& options,
                                                                const Url& url);

/// The figures that viewers record while `on`.
struct LoadRecord {
  bool on = false;
  LoadFigures figures;

  /// Records a complete frame.
  void whole(double delay_ms);
};

/// A viewer of a package that starts at the share `phase`, 0 to 1, of the loop.
std::unique_ptr<CrowdMember> package_viewer(std::shared_ptr<const PackageRequests> requests,
                                            double phase, LoadRecord& record);

/// A viewer of a live stream.
std::unique_ptr<CrowdMember> live_viewer(const Url& url, const std::string& token,
                                         LoadRecord& record);

}  // namespace pointreel
