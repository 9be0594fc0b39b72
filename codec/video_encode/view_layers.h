#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "codec/video/views.h"
#include "codec/video_encode/surface_points.h"
#include "pointreel/executor.h"

namespace pointreel {

/// The depth of each pixel of a layer of a view.
struct ViewLayer {
  static constexpr float kNone = -1.0f;

  /// The part of the view that is kept. Outside of it there is nothing.
  int left = 0, top = 0, width = 0, height = 0;
  std::vector<float> depth;  ///< in pixels along the view's axis, or kNone; empty if nobody is

  bool used() const { return !depth.empty(); }
  float at(int x, int y) const {
    const bool kept = x >= left && x < left + width && y >= top && y < top + height;
    return kept ? depth[index(x, y)] : kNone;
  }
  /// Of a pixel that is kept.
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - top) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x - left);
  }
  /// Calls `body(x, y, depth)` for each pixel that has a depth.
  template <class Body>
  void for_each(const Body& body) const {
    const float* value = depth.data();
    for (int y = top; y < top + height; ++y)
      for (int x = left; x < left + width; ++x, ++value)
        if (*value != kNone) body(x, y, *value);
  }
};
using ViewLayers = std::array<std::array<ViewLayer, kViewLayers>, kViews>;

/// Lays the points of a frame into the layers of the views. Points of a view that hang together
/// are a patch of the surface, and lie in one layer: the one in which such a patch was in the frame
/// before, if there is one, and in which patches of very different depth are far away. Where points
/// are left that no pixel is near, they are tried again in other layers; patches of a few pixels
/// that do not fit are left out.
///
/// `labels`: the view of each point. `before`: the layers of the frame before, or null.
ViewLayers lay_into_views(const SurfacePoints& points, const std::vector<std::uint8_t>& labels,
                          const ViewLayers* before, const Executor& executor = {});

}  // namespace pointreel
