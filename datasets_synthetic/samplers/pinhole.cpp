#include "datasets_synthetic/samplers/pinhole.h"

#include "datasets_synthetic/vectors.h"

namespace pointreel {

Pinhole look_at(const glm::dvec3& position, const glm::dvec3& target) {
  Pinhole view;
  view.position = position;
  view.forward = unit(target - position);
  view.right = unit(glm::cross(view.forward, glm::dvec3(0, 1, 0)));
  view.up = glm::cross(view.right, view.forward);
  return view;
}

}  // namespace pointreel
