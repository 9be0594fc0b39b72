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

  /// For each of kShadowEdge by kShadowEdge texels, the means of the nearest to the light and of
  /// its square, one after the other.
  std::span<const float> moments() const { return moments_; }

 private:
  std::vector<std::vector<float>> parts_;  ///< the nearest to the light, of parts of the instances
  std::vector<float> rows_;                ///< the moments, blurred along rows only
  std::vector<float> moments_;
};

}  // namespace pointreel
