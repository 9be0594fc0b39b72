#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/instance_buffer.h"
#include "client/render/instances.h"
#include "client/render/region.h"
#include "client/scene/camera.h"
#include "client/scene/cut.h"
#include "client/scene/frame.h"
#include "pointreel/error.h"

namespace pointreel {

/// The instances of a scene for a view of it: cuts of the frames' trees and points of their clouds
/// in one buffer, made anew only where something changed. Needs the renderer's OpenGL context.
class SceneInstances {
 public:
  struct Stats {
    std::uint32_t visited = 0, out_of_view = 0, below_pixel = 0, hidden = 0;  ///< DrawStats'
    double cut_ms = 0.0;  ///< of the last update; 0 where no frame was cut
  };

  /// `scene` as `camera` sees it in a picture of `size` pixels. Keeps hold of the frames. The error
  /// says that the driver has no memory for so many; there are no instances then.
  Result<void> update(const Scene& scene, const Camera& camera, glm::ivec2 size,
                      const ElementStyle& style, float pixel_size);

  InstanceBuffer& buffer() { return instances_; }
  const InstanceBuffer& buffer() const { return instances_; }
  const InstanceBounds& bounds() const { return bounds_; }
  /// Of the instances' coordinates, in the world.
  const glm::dvec3& origin() const { return origin_; }
  /// Some frame's normals have a line but no sign.
  bool normals_estimated() const { return normals_estimated_; }
  const Stats& stats() const { return stats_; }

 private:
  /// What the cuts depend on.
  struct View {
    Camera camera;
    glm::ivec2 size;
    float pixel_size;
    bool operator==(const View&) const = default;
  };
  /// One frame's part.
  struct Part {
    bool is_tree = false;
    VoxelCut cut;
    CutStats stats;
    std::size_t most = 0;  ///< instances that it may become
  };

  void cut(const Scene& scene);
  std::size_t pack(const PlacedFrame& placed, const Part& part, std::span<Instance> out);

  std::optional<View> view_;  ///< none: nothing is up to date
  Scene scene_;
  ElementStyle style_;
  std::vector<Part> parts_;
  InstanceBuffer instances_;
  InstanceBounds bounds_;
  glm::dvec3 origin_{0.0};
  bool normals_estimated_ = false;
  Stats stats_;
};

}  // namespace pointreel
