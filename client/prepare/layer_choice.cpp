#include "client/prepare/layer_choice.h"

#include <algorithm>

#include "client/scene/cut.h"
#include "codec/octree/octree_codec.h"
#include "pointreel/octree.h"

namespace pointreel {

bool draws_normals(DrawMode mode, bool colored, bool shown) {
  return shown || mode == DrawMode::surfel || mode == DrawMode::strip || !colored;
}

/// Nodes are judged by the mean silhouette of a cube, 1.5 faces; pixels of video lie on the
/// surface, and may be wider by the root of that (common/FORMULAS.md, "Points of video").
constexpr float kSurfacePixel = 1.2247449f;

int level_for(const Manifest& manifest, const Camera& camera, glm::ivec2 size, float pixel_size) {
  if (manifest.codec == "video") pixel_size *= kSurfacePixel;
  int level = 0;
  // Frames may have cubes of their own within that of the bounds (--cube frame). The larger the
  // cube, the more levels are needed.
  for (const Segment& segment : manifest.segments) {
    level = std::max(level, finest_level(segment.cube, manifest.bounds, camera, size, pixel_size));
  }
  return level;
}

std::uint32_t layers_down_to(int level, int depth) {
  const int most = layer_count(depth);
  int layers = 1;
  while (layers < most && last_level_of_layer(layers - 1, depth) < level) ++layers;
  return static_cast<std::uint32_t>(layers);
}

LayerRange layer_choice(const Manifest& manifest, DrawMode mode, int level, bool show_normals,
                        bool scalars) {
  LayerRange choice;
  choice.colors = manifest.colors;
  choice.normals = draws_normals(mode, manifest.colors, show_normals);
  if (manifest.codec == "video") choice.end = level <= kVideoBaseLevel ? 1 : 2;
  if (manifest.codec == "octree" && !scalars)
    choice.end = layers_down_to(level, std::min(static_cast<int>(manifest.depth_max), kMaxDepth));
  return choice;
}

void VoxelDepth::learn(const SceneFrame& frame) {
  if (frame.svo.node_count() == 0) return;
  // A frame that lacks levels only tells that it needs more than it has.
  const int least = frame.level == kWholeFrame ? frame.svo.depth : frame.level + 1;
  int depth = depth_;
  while (depth < least && !depth_.compare_exchange_weak(depth, least)) {
  }
}

int VoxelDepth::get() const {
  const int depth = depth_;
  return depth < 0 ? kWholeFrame : depth;
}

}  // namespace pointreel
