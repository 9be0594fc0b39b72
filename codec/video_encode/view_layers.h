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
  std::vector<float> depth;  ///< in pixels along the view's axis, or kNone; empty if nobody is

  bool used() const { return !depth.empty(); }
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
