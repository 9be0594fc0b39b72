#pragma once

#include "client/render/software/picture.h"
#include "client/render/view.h"
#include "client/scene/camera.h"
#include "client/scene/floor_grid.h"
#include "pointreel/executor.h"

namespace pointreel {

/// Darkens drawn pixels beside nearer ones (opengl/eye_dome_lighting.h). `strength` > 0.
void light_eye_dome(float strength, const Executor& executor, Picture& picture);

/// Smooths the outlines of what was drawn against the background (opengl/outlines.h). Leaves alpha
/// as it is.
void smooth_outlines(const PixelRect& region, const Executor& executor, Picture& picture);

/// Blends the lines of a floor over a picture (opengl/floor.h). `view` has the coordinates of
/// floor_origin. Leaves alpha and depths as they are.
void draw_floor(const FloorGrid& grid, const Camera& camera, const PictureView& view,
                const glm::vec3& background, Picture& picture);

}  // namespace pointreel
