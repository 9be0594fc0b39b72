#pragma once

#include <cstddef>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/light_probe.h"
#include "client/render/shading.h"
#include "client/render/software/picture.h"
#include "client/render/software/shadow_map.h"
#include "client/render/view.h"
#include "codec/surface/lanes.h"
#include "pointreel/executor.h"

namespace pointreel {

/// What is found once for every square of two by two pixels, a cell.
struct ShadingCells {
  std::vector<float> depth;  ///< reversed; 0: nothing is drawn
  std::vector<float> open;   ///< the share of light from all around that nothing nearby takes
  std::vector<float> bend;   ///< mean curvature; > 0 where the surface bulges; only if it is shown

  /// For a picture of this size in pixels.
  void resize(glm::ivec2 picture);
  /// The index of the cell that shows a pixel.
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y / 2 + 1) * stride() + static_cast<std::size_t>(x / 2 + 1);
  }
  /// Between the indices of a cell and of the one above it.
  std::size_t stride() const { return static_cast<std::size_t>(size_.x) + 2 + kLanes; }
  /// Gives cells at the border a neighbour on each side, with the same values.
  void extend_borders();

 private:
  glm::ivec2 size_{0};  ///< without the neighbours, and the room behind rows to read lanes there
};

/// Lights the pixels of a picture once it is known what they show: Pfister et al., Surfels, section
/// 7.5.
class ScreenShading {
 public:
  /// Lights all that is drawn. The colours of the picture are those of surfaces.
  void light(const ShadingView& shading, const LightProbe& probe, const ShadowMap& shadow,
             const PictureView& view, const Executor& executor, Picture& picture);

  /// Darkens the background where it shows the floor in the shadow of the scene.
  static void shade_floor(const ShadingView& shading, const ShadowMap& shadow,
                          const PictureView& view, const Executor& executor, Picture& picture);

 private:
  void find_open(const ShadingView& shading, const PictureView& view, const Executor& executor,
                 const Picture& picture);

  ShadingCells cells_;
};

}  // namespace pointreel
