#pragma once

#include "client/source/fetched.h"
#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

namespace pointreel {

/// The points of a frame of video, with normals. `layer.group` is not null. Decoders of the last
/// few groups are kept, so that frames that follow each other are decoded once each; any other
/// frame takes the decoding of those before it in its group, too. Safe to call from any thread.
Result<PointCloud> decode_video(const FetchedLayer& layer, const DecodeLimits& limits);

}  // namespace pointreel
