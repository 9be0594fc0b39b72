#include "pointreel/up.h"

namespace pointreel {

glm::dvec3 Up::direction() const {
  glm::dvec3 up(0.0);
  up[axis_] = reversed_ ? -1.0 : 1.0;
  return up;
}

std::string Up::text() const {
  return reversed_ ? std::string{'-', letter()} : std::string{letter()};
}

std::optional<Up> parse_up(std::string_view text) {
  const bool reversed = text.starts_with('-');
  if (reversed) text.remove_prefix(1);
  if (text != "x" && text != "y" && text != "z") return std::nullopt;
  return Up(text[0], reversed);
}

}  // namespace pointreel
