#pragma once

#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/bindings/frames/point_frame.h"
#include "client/prepare/prepare.h"
#include "client/render/image.h"
#include "client/scene/camera.h"
#include "client/scene/draw_options.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "pointreel/up.h"

namespace pointreel {

struct PictureOptions {
  glm::ivec2 size{1280, 720};
  DrawMode mode = DrawMode::surfel;
  std::optional<glm::dvec2> view;  ///< yaw and pitch in degrees; absent: from slightly above
  double zoom = 1.0;               ///< > 0; 1 shows all of the box
  Up up = 'y';
  std::optional<Target> target;  ///< what the camera looks at; absent: the middle of the box
  /// Where the colours come from; a scalar field comes before it.
  ColorSource color = ColorSource::colors;
  ScalarChoice scalar;
  bool lit = true;
  Light light = Light::flat;
  std::optional<Box> box;  ///< what the picture shows; absent: the frame's points, but for strays
  glm::vec3 background = DrawOptions{}.background;  ///< sRGB, 0 to 1
};

/// Draws a frame as the player does when it writes pictures, by the processor alone.
Result<Image> picture_of(const PointFrame& frame, const PictureOptions& options);

}  // namespace pointreel
