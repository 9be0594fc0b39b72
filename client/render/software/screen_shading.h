#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "client/render/light_probe.h"
#include "client/render/shading.h"
#include "client/render/software/picture.h"
#include "client/render/software/shadow_map.h"
#include "client/render/view.h"
#include "pointreel/executor.h"

namespace pointreel {

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
  /// A square of two by two pixels.
  struct Cell {
    float depth;  ///< reversed; 0: nothing is drawn
    float open;   ///< the share of light from all around that nothing nearby takes
    float bend;   ///< mean curvature; > 0 where the surface bulges; only if that is shown
  };
  void find_open(const ShadingView& shading, const PictureView& view, const Executor& executor,
                 const Picture& picture);
  /// The means of cells around a pixel that show the same surface.
  Cell cell_at(int x, int y, float depth) const;

  glm::ivec2 cells_size_{0};
  std::vector<Cell> cells_;
};

}  // namespace pointreel
