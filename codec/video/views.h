#pragma once

#include <array>

/// The views of a layered depth video: six orthographic cameras that look along the axes of a cube.
/// Based on H. Pfister et al., "Surfels: Surface Elements as Rendering Primitives", 2000, sections
/// 5 and 6 (layered depth cubes).
namespace pointreel {

inline constexpr int kViews = 6;
/// The most layers of depth in a view: points that lie behind each other.
inline constexpr int kViewLayers = 4;

/// What a view sees: points that face along +x, -x, +y, -y, +z and -z, in this order.
struct ViewAxes {
  int depth;     ///< the axis along which the view looks
  int u, v;      ///< the axes of its pictures, to the right and down
  float facing;  ///< 1 or -1: the side of the axis that its points face
};

inline constexpr std::array<ViewAxes, kViews> kViewAxes{{{0, 2, 1, 1.0f},
                                                         {0, 2, 1, -1.0f},
                                                         {1, 0, 2, 1.0f},
                                                         {1, 0, 2, -1.0f},
                                                         {2, 0, 1, 1.0f},
                                                         {2, 0, 1, -1.0f}}};

}  // namespace pointreel
