#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/instance.h"
#include "client/render/light_probe.h"
#include "client/render/region.h"
#include "client/render/renderer.h"
#include "client/render/scene_instances.h"
#include "client/render/scene_strips.h"
#include "client/render/shading.h"
#include "client/render/software/hole_filling.h"
#include "client/render/software/picture.h"
#include "client/render/software/picture_texture.h"
#include "client/render/software/screen_shading.h"
#include "client/render/software/shadow_map.h"
#include "client/render/software/solids.h"
#include "client/render/software/splats.h"
#include "client/render/software/triangles.h"
#include "client/render/view.h"
#include "pointreel/executor.h"

namespace pointreel {

/// The milliseconds of each step of a picture, as in Table 3 of Pfister et al. Steps that share a
/// pass over the tiles share its time.
struct SoftwareStages {
  double clear = 0.0;
  double warp = 0.0;        ///< packing the cut, and projecting it into the tiles
  double visibility = 0.0;  ///< splatting depths
  /// Weighted means of what is visible; all of voxels, points and strips.
  double shading = 0.0;
  double light = 0.0;           ///< all but flat light: shadows and pixels
  double reconstruction = 0.0;  ///< holes, eye-dome lighting, outlines
};

/// Draws scenes with the processor, by the pipeline of H. Pfister, M. Zwicker, J. van Baar, M.
/// Gross, "Surfels: Surface Elements as Rendering Primitives", 2000, section 7: surfels are warped
/// into the picture block by block of a cut through the tree, discs are splatted into a depth
/// buffer, which decides what is visible, visible surfels are reconstructed by weighted means, and
/// holes are detected and filled by pull and push. The rules are those of the OpenGL renderer, so
/// that both draw the same picture, up to small differences in rounding.
///
/// The picture is drawn in tiles by all threads of the executor. It is the same to the byte
/// whatever the number of threads and whatever instructions the processor has. Draws without
/// OpenGL; only `present` and `texture` need a context, the same every time.
///
/// DrawOptions::instancing has no meaning here, and voxels are always drawn with the faces that the
/// eye can see.
class SoftwareRenderer final : public Renderer {
 public:
  explicit SoftwareRenderer(Executor executor);

  std::string describe() const override;
  using Renderer::draw;
  Result<DrawStats> draw(const Scene& scene, const Camera& camera, glm::ivec2 size,
                         const DrawOptions& options) override;
  void present(unsigned framebuffer) override;
  unsigned texture() override;
  std::optional<glm::dvec3> point_at(const glm::dvec2& pixel) const override;
  Result<Image> read_pixels() const override;

  /// Of the last picture.
  const SoftwareStages& stages() const { return stages_; }

 private:
  /// Instances in ordinary memory.
  class Memory final : public InstanceMemory {
   public:
    std::span<Instance> write(std::size_t count) override;
    void keep(std::size_t count) override { size_ = count; }
    std::span<const Instance> instances() const { return {memory_.data(), size_}; }

   private:
    std::vector<Instance> memory_;  ///< never shrinks
    std::size_t size_ = 0;
  };

  Result<void> resize(glm::ivec2 size);
  void clear(const glm::vec3& background);
  /// `late`: null if colours are lit before pixels are known.
  void draw_surfels(const PictureView& view, const ShadingView* late, const DrawOptions& options);
  void light(const PictureView& view, const ShadingView& late, const DrawOptions& options);
  /// Lights pixels of surfels and strips late, if at all, fills holes, and darkens what lies deep.
  void close_surface(const PictureView& view, const ShadingView* late, const DrawOptions& options);

  const Executor executor_;
  SceneInstances instances_;
  SceneStrips strips_;
  Memory memory_;
  Splats depth_splats_, color_splats_;
  Solids solids_;
  Triangles triangles_;
  HoleFilling holes_;
  LightProbes probes_;
  ShadowMap shadow_;
  ScreenShading screen_shading_;
  Picture picture_;
  PictureTexture texture_;
  // The last picture:
  SoftwareStages stages_;
  glm::ivec2 shown_{0};  ///< the size in which it is shown
  Camera camera_;
  glm::vec3 background_{0.0f};
  PixelRect drawn_on_;  ///< the rest of the picture is background
};

}  // namespace pointreel
