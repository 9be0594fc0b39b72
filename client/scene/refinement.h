#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/scene/camera.h"
#include "client/scene/divided_patch.h"
#include "client/scene/frame.h"
#include "codec/surface/point_surface.h"

namespace pointreel {

/// Divides the surfels of a frame that look larger than a few pixels, so that a close view shows a
/// surface and not discs: view-dependent up-sampling (G. Guennebaud, M. Germann, M. Gross, "Dynamic
/// Sampling and Rendering of Algebraic Point Set Surfaces", 2008, section 4).
///
/// Around each such surfel a sphere is fitted to its neighbours. Where its disc looks different
/// from the sphere, as at silhouettes, new surfels are placed in its plane as far as it is the
/// nearest of the frame's surfels, and go to the weighted mean of the spheres around them. Their
/// colours are weighted means over a few spacings between surfels, so that they keep the detail
/// that the samples have. Spheres are kept as long as the frame stays, and the surfels as long as
/// the camera does, too.
class Refinement {
 public:
  /// Divides what `camera`, in the coordinates of the frame's world, sees in a picture of `size`
  /// pixels. A frame without normals is left as it is. Shares ownership of the frame until another
  /// one comes.
  void run(std::shared_ptr<const SceneFrame> frame, const Camera& camera, glm::ivec2 size);
  /// Forgets everything.
  void clear() { *this = {}; }

  /// Takes the place of the divided ones.
  const std::vector<RefinedSurfel>& surfels() const { return surfels_; }
  /// For each point of the cloud, or leaf of the tree, whether it was divided. Empty if none was.
  const std::vector<bool>& divided() const { return divided_; }

 private:
  struct Wanted;

  std::vector<Wanted> find_wanted(const Camera& camera, glm::ivec2 size) const;
  void fit(std::span<const Wanted> wanted);
  void divide(std::span<const Wanted> wanted);

  std::shared_ptr<const SceneFrame> frame_;
  std::optional<Camera> camera_;
  glm::ivec2 size_{0};
  // The frame's points, once some may look large, and in their Morton order what was found around
  // them:
  PointCloud points_;
  std::vector<std::uint32_t> at_;  ///< of a point: its place in that order
  std::optional<PointSurface> surface_;
  std::vector<float> spacings_;       ///< about the distance between neighbours
  std::vector<std::uint32_t> slots_;  ///< of the patches of points; kNoSlot if there is none yet
  std::vector<SurfacePatch> patches_;
  // Of the last camera:
  std::vector<RefinedSurfel> surfels_;
  std::vector<bool> divided_;
};

}  // namespace pointreel
