#pragma once

#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/instance.h"
#include "pointreel/executor.h"

namespace pointreel {

/// What the key light sees of instances, blurred, so that shadows are soft: W. Donnelly, A.
/// Lauritzen, "Variance Shadow Maps", 2006.
class ShadowMap {
 public:
  /// `to_shadow` as in ShadingView.
  void draw(std::span<const Instance> instances, const glm::mat4& to_shadow,
            const Executor& executor);

  /// The share of the key light that reaches a point, given by its coordinates in the map. `apart`:
  /// less than this in front of it is no shadow. Light reaches all points outside of the map.
  float light_at(const glm::vec3& point, float apart) const;

 private:
  std::vector<std::vector<float>> parts_;  ///< the nearest to the light, of parts of the instances
  std::vector<glm::vec2> rows_;            ///< blurred along rows
  std::vector<glm::vec2> moments_;         ///< means of the nearest to the light, and of its square
};

}  // namespace pointreel
