#pragma once

#include <memory>
#include <string>

#include "client/source/live_source.h"

namespace pointreel {

/// A live stream as a manifest that grows, with short segments that any cache can hand on: `url` is
/// its folder or its reel.json. The manifest is asked for anew a few times for each segment.
/// Segments are fetched whole, and shown as evenly as they were captured (live_pacing.h); where the
/// link is too slow for them, with fewer layers. Frames are numbered as they come.
Result<std::unique_ptr<LiveSource>> open_http_live_source(const std::string& url,
                                                          const SourceOptions& options);

}  // namespace pointreel
