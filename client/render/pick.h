#pragma once

#include <optional>
#include <span>

#include <glm/glm.hpp>

#include "client/render/region.h"
#include "client/scene/camera.h"

namespace pointreel {

/// The pixels of a picture of `size` pixels in which `pick` looks for something near `at` (from the
/// lower left corner). Empty if `at` is outside of the picture.
PixelRect pick_area(const glm::dvec2& at, glm::ivec2 size);

/// The position in the world of what the picture shows at `at` or, if it shows nothing there, at
/// the nearest pixel of the area that shows something. `depths` are those of the area, row by row
/// from the lowest, reversed, 0 where nothing is.
std::optional<glm::dvec3> pick(const glm::dvec2& at, const PixelRect& area,
                               std::span<const float> depths, const Camera& camera,
                               glm::ivec2 size);

}  // namespace pointreel
