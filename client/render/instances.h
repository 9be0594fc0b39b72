#pragma once

#include <span>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "client/scene/cut.h"
#include "client/scene/frame.h"

namespace pointreel {

/// What the graphics processor gets for each surfel, point or voxel, as it is read by the shaders.
struct Instance {
  glm::vec3 center;     ///< relative to Instances::origin
  float radius;         ///< of the splat, or half the voxel's edge
  glm::i16vec4 normal;  ///< unit vector times 32767, or zero where unknown; w unused
  glm::u8vec4 color;    ///< sRGB; w unused
};
static_assert(sizeof(Instance) == 28);

/// The instances of one draw call; reused from frame to frame.
struct Instances {
  glm::dvec3 origin{0.0};  ///< world coordinates of the local zero
  std::vector<Instance> items;
};

/// Colours that are absent are made from the normals: 0.5 + 0.5 n, read as sRGB. The paper, section
/// III, only says that its fake colour is "based on their normal vectors". Middle grey where the
/// normal is unknown too.
glm::u8vec3 fake_color(const glm::i16vec4& normal);

/// Surfels or points of a frame. Radii are those of the cloud; where it has none (a frame that was
/// prepared for another mode), half the diagonal of the octree's leaves.
void pack_points(const SceneFrame& frame, Instances& out);

/// Voxels: the cut's nodes with their mean attributes.
void pack_voxels(const SceneFrame& frame, std::span<const CutNode> cut, Instances& out);

}  // namespace pointreel
