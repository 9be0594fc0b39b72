#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "client/render/instance.h"
#include "client/render/region.h"
#include "client/scene/cut.h"
#include "client/scene/draw_options.h"
#include "client/scene/frame.h"
#include "client/scene/refinement.h"
#include "pointreel/executor.h"

namespace pointreel {

/// Whether elements of a frame are drawn in colours that its source has.
bool shows_own_colors(const SceneFrame& frame, ColorSource color);

/// The colour of an element with ColorSource::normals: 0.5 + 0.5 n, read as sRGB, and middle grey
/// if the normal is unknown. Slomp et al., Geometry Instancing, section III only says that its fake
/// colour is "based on their normal vectors".
glm::u16vec3 fake_color(const glm::i16vec4& normal);

/// Which elements of a scene are drawn, and in which colours.
struct ElementStyle {
  DrawMode mode = DrawMode::surfel;
  ColorSource color = ColorSource::colors;
  bool fill_holes = true;  ///< false: leave out the voxels that fill gaps (gap_filling.h)
  bool refine = false;     ///< divide surfels that look large (refinement.h)

  bool operator==(const ElementStyle&) const = default;
};

/// Packs the points of a frame's cloud into `out`, an instance for each. Centres are relative to
/// the cloud's origin and moved by `offset`. Radii are those of the cloud, enlarged with
/// DrawMode::point so that squares close surfaces; if it has none (because the frame was prepared
/// for another mode), half the diagonal of the octree's leaves. Leaves out points that were
/// `divided`, if that is not empty. Returns the number of instances packed. Grows `bounds`. The
/// result does not depend on the executor.
std::size_t pack_points(const SceneFrame& frame, const ElementStyle& style, const glm::vec3& offset,
                        const std::vector<bool>& divided, std::span<Instance> out,
                        InstanceBounds& bounds, const Executor& executor = {});

/// Packs the nodes of a cut through a frame's tree, with their mean attributes, into `out`, which
/// has room for all of them. Centres are relative to the cube's origin and moved by `offset`. The
/// radii of voxels are half their edges; other radii are the frame's, enlarged as above. If the
/// frame knows the neighbours of its leaves, voxels that these hide from `eye` (also relative to
/// the cube's origin) are left out, and so are leaves that were `divided`, if that is not empty.
/// Returns the number of instances packed. Grows `bounds`.
std::size_t pack_nodes(const SceneFrame& frame, std::span<const CutNode> cut,
                       const ElementStyle& style, const glm::vec3& eye, const glm::vec3& offset,
                       const std::vector<bool>& divided, std::span<Instance> out,
                       InstanceBounds& bounds, const Executor& executor = {});

/// Packs all surfels of a refinement of a frame, as above.
void pack_refined(const SceneFrame& frame, std::span<const RefinedSurfel> surfels,
                  ColorSource color, const glm::vec3& offset, std::span<Instance> out,
                  InstanceBounds& bounds);

/// Packs the representative surfel of a node of a frame's strips, as above. Its radius is 0.
Instance pack_representative(const SceneFrame& frame, const StripNode& node, ColorSource color,
                             const glm::vec3& offset);

}  // namespace pointreel
