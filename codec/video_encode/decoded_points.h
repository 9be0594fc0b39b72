#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <glm/glm.hpp>

#include "codec/video/pixel_depths.h"
#include "codec/video/video_group.h"

/// What players will decode of a frame.
namespace pointreel {

/// The depth of each pixel of the pictures, in pixels along its view's axis from the cube's corner;
/// kNoPoint where there is no point.
struct DecodedDepth {
  static constexpr float kNoPoint = -1e6f;
  std::vector<float> depth;
};

DecodedDepth decoded_depth(const VideoGroup& group, const PixelDepths& depths);

/// How squarely a view sees a surface: from -1 to 1.
inline float faces(const glm::vec3& normal, std::size_t view) {
  return kViewAxes[view].facing * normal[kViewAxes[view].depth];
}
std::size_t faced_most(const glm::vec3& normal);

/// Finds decoded points by their place, in pixels from the cube's corner.
class DecodedPoints {
 public:
  static constexpr std::uint32_t kNobody = ~0u;

  /// Both must outlive it.
  DecodedPoints(const VideoGroup& group, const DecodedDepth& decoded);

  struct Found {
    std::uint32_t pixel = kNobody;
    float square = std::numeric_limits<float>::max();  ///< of the distance
  };

  /// Whether there is a decoded point of a view within `reach` pixels of a place.
  bool has_near(std::size_t view, const glm::vec3& place, int reach) const;

  /// The nearest decoded point of a view within `reach` pixels along each of the picture's axes.
  void look(std::size_t view, const glm::vec3& place, int reach, Found& found) const;

 private:
  const VideoGroup& group_;
  const DecodedDepth& decoded_;
  std::array<std::vector<const Patch*>, kViews> patches_;
};

}  // namespace pointreel
