#pragma once

#include <cstdint>
#include <vector>

#include "codec/video/av1_decoder.h"
#include "codec/video/video_group.h"
#include "pointreel/cloud.h"
#include "pointreel/executor.h"

/// Pictures of depth and colour -> points.
namespace pointreel {

/// The depth of each pixel of the pictures, in pixels along its view's axis from the cube's corner;
/// kNoPoint where there is no point.
struct DepthPicture {
  static constexpr float kNoPoint = -1e6f;
  std::vector<float> depth;
};

/// The points of a decoded picture of depth. `mask`: pixel_mask. Points that fewer than three of
/// their eight neighbours support, within two pixels of depth, are left out: coding throws single
/// pixels at the edge of a patch far off the surface.
DepthPicture read_depth(const VideoGroup& group, const std::vector<std::uint8_t>& mask,
                        const PlaneView<std::uint16_t>& picture, const Executor& executor = {});

/// One point for each pixel that has one, patch by patch, row by row, relative to the group's
/// origin. Normals are those of the slopes of the depth around it. `colors` may be null.
PointCloud points_of(const VideoGroup& group, const DepthPicture& depth, const Av1Picture* colors,
                     bool normals, const Executor& executor = {});

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
glm::vec3 rgb_of(const glm::vec3& ycbcr);
glm::vec3 ycbcr_of(const glm::vec3& rgb);

}  // namespace pointreel
