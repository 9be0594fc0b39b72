#pragma once

#include <cstddef>

#include "codec/video/av1_decoder.h"
#include "codec/video/pixel_depths.h"
#include "codec/video/video_group.h"
#include "pointreel/cloud.h"
#include "pointreel/executor.h"

/// Pictures of depth and colour -> points.
namespace pointreel {

/// What points have besides their positions and colours.
struct PointParts {
  bool normals = true;  ///< those of the slopes of the depth around the pixel
  bool radii = false;   ///< with normals: edges of squares of the surface that a pixel stands for
};

/// One point for each pixel that has one, patch by patch, row by row, relative to the group's
/// origin. `colors` may be null. There is room for so many `spare` points more.
PointCloud points_of(const VideoGroup& group, const PixelDepths& depths, const Av1Picture* colors,
                     const PointParts& parts, std::size_t spare = 0, const Executor& executor = {});

/// The place of a pixel of a patch, in pixels from the cube's corner.
inline glm::vec3 place_of(const Patch& patch, int x, int y, float depth) {
  const ViewAxes& axes = kViewAxes[static_cast<std::size_t>(patch.view)];
  glm::vec3 place;
  place[axes.depth] = depth;
  place[axes.u] = static_cast<float>(patch.x + x) + 0.5f;
  place[axes.v] = static_cast<float>(patch.y + y) + 0.5f;
  return place;
}

/// ITU-R BT.709 with full range: from 0 to 255 each; cb and cr have their zero at 128.
glm::vec3 ycbcr_of(const glm::vec3& rgb);

}  // namespace pointreel
