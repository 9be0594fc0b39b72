#pragma once

#include <vector>

#include "codec/video/video_group.h"
#include "codec/video_encode/decoded_points.h"
#include "codec/video_encode/fill_picture.h"
#include "codec/video_encode/surface_points.h"
#include "pointreel/executor.h"

namespace pointreel {

/// The planes of a picture of colours; those of chroma are half as wide and high.
struct ColorPlanes {
  Plane luma, cb, cr;
};

/// The colours of decoded points: each has the mean of the source's points that it is the nearest
/// to, together with that of the source's point nearest to it.
ColorPlanes color_planes(const VideoGroup& group, const DecodedDepth& decoded,
                         const SurfacePoints& source, const Executor& executor = {});

}  // namespace pointreel
