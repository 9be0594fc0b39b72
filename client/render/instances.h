#pragma once

#include <cstddef>
#include <span>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "client/render/instance_buffer.h"
#include "client/render/region.h"
#include "client/scene/cut.h"
#include "client/scene/draw_options.h"
#include "client/scene/frame.h"

namespace pointreel {

/// Colours that are absent are made from the normals: 0.5 + 0.5 n, read as sRGB. The paper, section
/// III, only says that its fake colour is "based on their normal vectors". Middle grey where the
/// normal is unknown too.
glm::u16vec3 fake_color(const glm::i16vec4& normal);

/// What is drawn of a scene, and in which colours.
struct ElementStyle {
  DrawMode mode = DrawMode::surfel;
  ColorSource color = ColorSource::colors;
  bool fill_holes = true;  ///< else without the voxels that fill gaps (gap_filling.h)

  bool operator==(const ElementStyle&) const = default;
};

/// Surfels or points of a frame's cloud, relative to its cloud's origin and moved by `offset`;
/// `out` has one for each point. Radii are those of the cloud; where it has none (a frame that was
/// prepared for another mode), half the diagonal of the octree's leaves. `bounds` grows by them.
void pack_points(const SceneFrame& frame, ColorSource color, const glm::vec3& offset,
                 std::span<Instance> out, InstanceBounds& bounds);

/// Nodes of a cut through a frame's tree with their mean attributes, relative to the cube's origin
/// and moved by `offset`; `out` has room for all. The radii of voxels are half their edges, those
/// of others the frame's. Voxels that their neighbours hide from `eye`, which is relative to the
/// cube's origin too, are left out where the frame knows the neighbours: how many are there.
std::size_t pack_nodes(const SceneFrame& frame, std::span<const CutNode> cut,
                       const ElementStyle& style, const glm::vec3& eye, const glm::vec3& offset,
                       std::span<Instance> out, InstanceBounds& bounds);

}  // namespace pointreel
