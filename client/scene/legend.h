#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "client/scene/frame.h"

namespace pointreel {

/// What the colours of a scene mean, in words: a ramp between two numbers, or the labels.
struct Legend {
  std::string title;        ///< the name of the scalar field
  std::string least, most;  ///< at the ends of the ramp; empty if there are labels
  std::vector<std::pair<glm::u8vec3, std::string>> labels;

  bool operator==(const Legend&) const = default;
};

/// Of the first frame that shows a scalar field; nothing if none does.
std::optional<Legend> legend_of(const Scene& scene);

}  // namespace pointreel
