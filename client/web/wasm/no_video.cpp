#include "client/source/video_groups.h"

namespace pointreel {

// The page plays the octree that the video stands on (reel.cpp).
Result<PointCloud> decode_video(const FetchedLayer&, const DecodeLimits&) {
  return fail(ErrorCode::unsupported, "video is not played in a browser");
}

}  // namespace pointreel
