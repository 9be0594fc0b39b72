#pragma once

#include <memory>
#include <string>

#include "client/source/live_source.h"

namespace pointreel {

/// A live stream as a growing manifest with short segments, which any cache can pass on. `url`
/// names its folder or its reel.json. The manifest is requested a few times for each segment.
/// Segments are fetched whole, with fewer layers if the link is too slow for all, and their frames
/// are given as evenly as they were captured (live_pacing.h). Frames are numbered as they come.
Result<std::unique_ptr<LiveSource>> open_http_live_source(const std::string& url,
                                                          const SourceOptions& options);

}  // namespace pointreel
