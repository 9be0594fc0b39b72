#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/instance.h"
#include "client/render/scene_instances.h"
#include "client/scene/camera.h"
#include "client/scene/draw_options.h"
#include "client/scene/draw_stats.h"
#include "client/scene/frame.h"
#include "client/scene/strip_cut.h"

namespace pointreel {

/// The strips of a scene as a camera sees them. Their vertices are the points of the frames'
/// clouds, as SceneInstances packs them.
class SceneStrips {
 public:
  /// The strips of a frame.
  struct Part {
    const SurfelStrips* strips = nullptr;
    /// Which has the strips. Unlike a pointer, it differs from that of a later frame that has the
    /// same address.
    std::weak_ptr<const SceneFrame> frame;
    std::uint32_t first_vertex = 0;  ///< of the scene's; added to the indices
    StripCut cut;
  };

  /// Cuts the strips of a scene, whose instances were updated before. Fills in what the cut says of
  /// the picture, in triangles. The frames live until the next call.
  void update(const Scene& scene, const Camera& camera, glm::ivec2 size, const DrawOptions& options,
              const SceneInstances& instances, DrawStats& stats);

  std::span<const Part> parts() const { return parts_; }
  /// Representative surfels, which are drawn as points.
  std::span<const Instance> points() const { return points_; }

 private:
  std::vector<Part> parts_;
  std::vector<Instance> points_;
};

}  // namespace pointreel
