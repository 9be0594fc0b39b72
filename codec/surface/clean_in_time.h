#pragma once

#include <optional>
#include <span>
#include <vector>

#include "codec/surface/clean.h"
#include "codec/surface/surface_motion.h"
#include "pointreel/cloud.h"
#include "pointreel/executor.h"

namespace pointreel {

/// The colours of a piece of surface, as they were measured.
struct PieceColor {
  glm::vec3 mean{0.0f};
  float variance = 0.0f;  ///< of one point, over all channels
  float points = 0.0f;
};

/// A frame that was cleaned by itself, and what it takes to clean frames near it in time.
struct CleanedFrame {
  PointCloud cloud;  ///< as `clean` leaves it, which is with normals if it was cleaned
  CleanReport report;
  BeforeCleaning before;
  bool had_normals = false;        ///< before it was cleaned
  SurfacePyramid pieces;           ///< empty if other frames cannot help
  std::vector<PieceColor> colors;  ///< of the finest pieces; empty if the frame has none
};

CleanedFrame clean_alone(PointCloud cloud, const CleanOptions& options,
                         const Executor& executor = {});

/// A frame, cleaned again with what the frames around it in time say about the same surface.
struct CleanedInTime {
  PointCloud cloud;  ///< the points of the frame that cleaning alone leaves, with normals
  CleanReport report;
};

/// The points of the frames around it, as they were measured, are carried along by the motion of
/// the surface (surface_motion.h). The surface is then fitted to all of them, within a radius that
/// is smaller because they are denser. Where the surface of another frame has not the same shape,
/// because it moves too fast, or because it was hidden or is somewhere else, that frame has no say;
/// where none has, the frame is cleaned about as it is alone. The same holds for colours that
/// change. Other frames count if they were cleaned, if they are as noisy, if both or none have
/// colours, and if they are not the same frame again. Points have the colours, normals and places
/// of the surface; nothing is added.
///
/// Nothing if the frame was not cleaned or has little noise (at most a quarter of the spacing), or
/// if no other frame counts. With four other frames it takes about one and a half times as long as
/// `clean`. The result does not depend on the executor.
std::optional<CleanedInTime> clean_in_time(const CleanedFrame& frame,
                                           std::span<const CleanedFrame* const> around,
                                           const CleanOptions& options,
                                           const Executor& executor = {});

}  // namespace pointreel
