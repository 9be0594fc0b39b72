#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "client/scene/camera.h"
#include "client/strips/strips.h"

namespace pointreel {

/// What a camera sees of strips: the tree is walked from the root, and left where it is out of
/// view, turned away, or so small that its representative surfel is drawn as a point. T. Boubekeur,
/// P. Reuter, C. Schlick, "Surfel Stripping", 2005, sections 3.4 and 3.5.
struct StripCut {
  /// Successive elements of SurfelStrips::indices: whole strips.
  struct Range {
    std::uint32_t first, count;
  };
  // In their order; none of them is long. Which sides of triangles are seen is known from cones of
  // normals; if the signs of normals are unknown, it counts as mixed.
  std::vector<Range> facing;  ///< all triangles face the eye
  std::vector<Range> mixed;
  std::vector<Range> turned_away;     ///< none does
  std::vector<std::uint32_t> points;  ///< nodes that are drawn as points; none of them turned away
  std::uint32_t visited = 0;          ///< nodes
  std::uint32_t triangles = 0;        ///< of those that face the eye, and of mixed ones
  std::uint32_t backs = 0;            ///< of those that are turned away
  /// Triangles that were left out.
  std::uint32_t out_of_view = 0, below_pixel = 0;
};

/// How strips are cut.
struct StripView {
  Camera camera;
  glm::dvec3 origin{0.0};   ///< of the surfels' coordinates, in the camera's world
  glm::ivec2 size{1};       ///< of the picture in pixels
  float pixel_size = 1.0f;  ///< a node whose sphere looks no wider, in pixels, is drawn as a point
  bool signs_unknown = false;  ///< of normals
};

/// Makes a cut, and keeps the memory of the last one. Never leaves out a triangle that is in view,
/// nor takes one that faces the eye for a back: spheres and cones are widened by what arithmetic
/// may be wrong (common/FORMULAS.md, "Visibility cones").
void cut_strips(const SurfelStrips& strips, const StripView& view, StripCut& cut);

}  // namespace pointreel
