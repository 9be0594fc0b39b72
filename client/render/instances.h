#pragma once

#include <span>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "client/render/instance_buffer.h"
#include "client/render/region.h"
#include "client/scene/cut.h"
#include "client/scene/frame.h"

namespace pointreel {

/// Colours that are absent are made from the normals: 0.5 + 0.5 n, read as sRGB. The paper, section
/// III, only says that its fake colour is "based on their normal vectors". Middle grey where the
/// normal is unknown too.
glm::u16vec3 fake_color(const glm::i16vec4& normal);

/// Surfels or points of a frame's cloud, relative to its cloud's origin; `out` has one for each
/// point. Radii are those of the cloud; where it has none (a frame that was prepared for another
/// mode), half the diagonal of the octree's leaves.
InstanceBounds pack_points(const SceneFrame& frame, std::span<Instance> out);

struct PackedNodes {
  InstanceBounds bounds;
  std::size_t count = 0;  ///< fewer than the cut has where voxels hide others
};

/// Nodes of a cut through a frame's tree with their mean attributes, relative to the cube's origin;
/// `out` has room for all. The radii of voxels are half their edges, those of others the frame's.
/// Voxels that their neighbours hide from `eye`, which is relative to the cube's origin too, are
/// left out where the frame knows the neighbours.
PackedNodes pack_nodes(const SceneFrame& frame, std::span<const CutNode> cut, DrawMode mode,
                       const glm::vec3& eye, std::span<Instance> out);

}  // namespace pointreel
