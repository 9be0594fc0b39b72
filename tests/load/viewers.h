#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "tests/load/crowd.h"
#include "tests/load/load_figures.h"

namespace pointreel {

/// What a package's viewers ask for: requests are written once for all of them.
struct PackageRequests {
  struct Frame {
    std::chrono::microseconds due{0};  ///< since the loop began
    unsigned layers = 0;
    std::string requests;
  };
  std::vector<Frame> frames;
  std::chrono::microseconds loop{0};
};
Result<std::shared_ptr<const PackageRequests>> package_requests(const LoadOptions& options,
                                                                const LoadUrl& url);

/// Viewers write what they see here while `on`.
struct LoadRecord {
  bool on = false;
  LoadFigures figures;

  void whole(double delay_ms);
};

/// Plays from `phase`, 0 to 1, of the loop on.
std::unique_ptr<CrowdMember> package_viewer(std::shared_ptr<const PackageRequests> requests,
                                            double phase, LoadRecord& record);

std::unique_ptr<CrowdMember> live_viewer(const LoadUrl& url, const std::string& token,
                                         LoadRecord& record);

}  // namespace pointreel
