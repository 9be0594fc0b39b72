#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/hole_rules.h"
#include "client/render/instance.h"
#include "client/render/instances.h"
#include "client/render/region.h"
#include "client/scene/camera.h"
#include "client/scene/cut.h"
#include "client/scene/frame.h"
#include "client/scene/refinement.h"
#include "pointreel/error.h"
#include "pointreel/executor.h"

namespace pointreel {

/// The instances of a scene as a camera sees it, one after another: the cuts of the frames' trees
/// and the points of their clouds. Remakes them only if something changed.
class SceneInstances {
 public:
  /// Large scenes are packed by the executor's threads; what they pack does not depend on it.
  explicit SceneInstances(Executor executor = {}) : executor_(std::move(executor)) {}

  struct Stats {
    std::uint32_t visited = 0, out_of_view = 0, below_pixel = 0, hidden = 0;  ///< as in DrawStats
    double cut_ms = 0.0;  ///< of the last update, with refinement; 0 if no frame was cut or refined
  };

  /// Makes the instances of `scene` as `camera` sees it in a picture of `size` pixels, and writes
  /// them to `memory`, which is the same every time. Shares ownership of the frames. Fails with
  /// ErrorCode::limit if there is too little memory; there are no instances then.
  Result<void> update(const Scene& scene, const Camera& camera, glm::ivec2 size,
                      const ElementStyle& style, float pixel_size, InstanceMemory& memory);

  const InstanceBounds& bounds() const { return bounds_; }
  /// The zero of the instances' coordinates, in the world.
  const glm::dvec3& origin() const { return origin_; }
  /// Whether the signs of some frame's normals are unknown.
  bool normals_estimated() const { return normals_estimated_; }
  /// Whether some frame is shown in colours of its own, which have light in them already.
  bool colored() const { return colored_; }
  /// One in this many surfels keeps its back.
  std::uint32_t one_back_in() const { return hole_rules::one_back_in(undivided_); }
  const Stats& stats() const { return stats_; }

 private:
  /// Everything that the cuts depend on.
  struct View {
    Camera camera;
    glm::ivec2 size;
    float pixel_size;
    bool operator==(const View&) const = default;
  };
  /// The contribution of a frame.
  struct Part {
    bool is_tree = false;  ///< drawn as a cut of its tree, not as its cloud
    VoxelCut cut;
    CutStats stats;
    Refinement refinement;
    std::size_t most = 0;  ///< no more instances than this
  };

  void cut(const Scene& scene);
  std::size_t pack(const PlacedFrame& placed, const Part& part, std::span<Instance> out);

  Executor executor_;
  std::optional<View> view_;  ///< of the instances; empty if there are none
  Scene scene_;
  ElementStyle style_;
  std::vector<Part> parts_;
  InstanceBounds bounds_;
  glm::dvec3 origin_{0.0};
  bool normals_estimated_ = false, colored_ = false;
  std::size_t undivided_ = 0;  ///< instances that are not in place of larger surfels
  Stats stats_;
};

}  // namespace pointreel
