#pragma once

#include <atomic>
#include <cstdint>

#include <glm/glm.hpp>

#include "client/scene/camera.h"
#include "client/scene/frame.h"
#include "client/source/fetched.h"
#include "pointreel/package.h"

namespace pointreel {

/// Whether a mode draws normals of a cloud, coloured or not: surfels and strips are oriented by
/// them, and where there is no colour, light on them shows the shape. (Voxels and points that have
/// colours are lit by their faces and from the eye: normals cost more to send than they show.)
/// `shown`: normals are what is shown.
bool draws_normals(DrawMode mode, bool colored, bool shown = false);

/// The finest level of any frame's tree that the camera can show in a picture of this size:
/// finest_level (cut.h) over the reel's cubes and bounds. kWholeFrame where no level is too fine.
int level_for(const Manifest& manifest, const Camera& camera, glm::ivec2 size, float pixel_size);

/// How many layers of an octree frame at most `depth` deep hold all its levels down to `level`.
std::uint32_t layers_down_to(int level, int depth);

/// The layers of a reel's frames that hold all levels down to `level`, and the attributes that are
/// drawn. `scalars`: all layers, since the last one holds the scalar fields of the leaves.
LayerRange layer_choice(const Manifest& manifest, DrawMode mode, int level,
                        bool show_normals = false, bool scalars = false);

/// How deep the delta rule has made the trees of voxels so far. Only whole trees can tell; later
/// frames are not fetched any deeper. A frame that ought to be deeper than what was fetched of it
/// raises the depth, and is fetched again. May be used from any thread.
class VoxelDepth {
 public:
  void learn(const SceneFrame& frame);
  /// kWholeFrame while nothing is known.
  int get() const;
  /// Call this when the rule has changed.
  void forget() { depth_ = -1; }

 private:
  std::atomic<int> depth_{-1};
};

}  // namespace pointreel
