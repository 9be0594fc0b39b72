#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "codec/surface/point_surface.h"

namespace pointreel {

/// A surfel between those of a frame, or in place of one.
struct RefinedSurfel {
  glm::vec3 position;  ///< relative to the frame's origin (that of the cube, or of the cloud)
  float radius;
  float of_divided;    ///< radius of the surfel that was divided
  glm::vec3 normal;    ///< of unit length
  glm::u16vec3 color;  ///< as in PointCloud; black if the frame has no colours
};

/// What a patch contributes to the surfels around it.
struct Blended {
  glm::vec3 position, normal;
  float curvature;
  glm::vec3 color;
  float reach;   ///< of its weight
  float far;     ///< from the patch that is divided
  float cosine;  ///< between its normal and that of the patch that is divided
};

/// A patch that is divided, and those around it. Places in its plane are looked at by eights.
class DividedPatch {
 public:
  explicit DividedPatch(const Blended& own) : own_(own) {}

  void add(const Blended& other) {
    others_[count_++] = other;
    widest_ = std::max(widest_, other.reach);
  }
  /// After the last was added. Sorts them, so that a place is compared only with those that may
  /// matter there.
  void finish();

  /// Adds a surfel of the surface for each place of a grid in the plane of the patch that is no
  /// farther away than `reach`, and to which no other patch is nearer. Their radii are not set.
  void divide(float reach, float step, std::vector<RefinedSurfel>& surfels) const;

 private:
  Blended own_;
  std::array<Blended, SurfacePatch::kMostNeighbors> others_;
  std::size_t count_ = 0;
  float widest_ = 0.0f;   ///< reach of the others
  float spacing_ = 0.0f;  ///< between surfels here
};

}  // namespace pointreel
