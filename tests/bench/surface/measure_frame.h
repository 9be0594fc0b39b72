#pragma once

#include <optional>
#include <vector>

#include "client/render/opengl/gl_renderer.h"
#include "client/scene/frame.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"
#include "tests/bench/render/truth.h"
#include "tests/bench/render/viewpoints.h"
#include "tests/bench/surface/surface_figures.h"
#include "tests/bench/surface/treatments.h"

namespace pointreel::bench {

/// A frame, the surface that it was sampled from, and pictures of that surface.
struct TrueFrame {
  struct View {
    Camera camera;
    TruthPicture truth;
  };
  FrameInTime source;
  /// Two frames of a still scene. Empty: movement is not measured.
  std::vector<FrameInTime> still;
  std::optional<Body> still_body;  ///< that they show
  TruthScene scene;
  CleanReport automatic;  ///< what cleaning with auto finds in `source`
  std::vector<View> views;
};

/// What a player makes of the frame when it was treated and encoded.
Result<SceneFrame> treated_scene(const TrueFrame& frame, const Treatment& treatment);

/// Treats the frame, encodes it as pack does, and compares what a player makes of the bytes with
/// the true surface. Times are medians of `runs`.
Result<SurfaceFigures> measure_frame(Renderer& renderer, const TrueFrame& frame,
                                     const Treatment& treatment, int runs);

}  // namespace pointreel::bench
