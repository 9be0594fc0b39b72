#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "codec/surface/support.h"
#include "pointreel/cloud.h"
#include "pointreel/executor.h"

namespace pointreel {

/// How `clean` looks for the surface, and how densely it samples it. Lengths are in the units of
/// the cloud.
struct CleanOptions {
  /// The radius of support of every place. Absent: chosen for each place by the spacing and the
  /// noise of the points around it, and clouds that are smooth or voxelised stay as they are.
  std::optional<double> radius = std::nullopt;
  /// The share of the curvature of the best sphere that the surface has: 0 for planes, 1 for the
  /// sphere itself. A little less is best, because noisy normals make spheres too small.
  double beta = 0.5;
  /// Whether clouds without normals are cleaned, too. Without normals, the two sides of parts that
  /// are thinner than some spacings cannot be told apart and become one.
  bool without_normals = true;
  /// Whether the sequence of which the cloud is a frame is worth cleaning. The frame then stays as
  /// it is, or is cleaned, although it is a little noisier, or smoother, than clouds by themselves
  /// may be: its neighbours do so, too.
  std::optional<bool> noisy = std::nullopt;
};

/// Why a cloud stays as it is.
enum class NotCleaned {
  few_points,
  no_normals,  ///< without CleanOptions::without_normals
  voxelised,
  smooth,
  repeated,    ///< its points are, nearby
  no_surface,  ///< it is no scan of one, or none fits within CleanOptions::radius
};

/// What `clean` found and did. Lengths are in the units of the cloud.
struct CleanReport {
  bool cleaned = false;                     ///< false: the cloud is as it was
  NotCleaned why = NotCleaned::few_points;  ///< unless it was cleaned
  double spacing = 0.0;     ///< between neighbouring points, the median; 0: not measured
  double noise = 0.0;       ///< standard deviation across the surface, the median
  double radius = 0.0;      ///< of support, the median
  std::size_t removed = 0;  ///< points that no surface supports
  /// The size of cells that tell apart what the cleaned points tell apart, also in the densest
  /// parts.
  double cell = 0.0;
};

/// What the points that cleaning leaves were before, and what was measured around them. Empty if
/// the cloud was not cleaned.
struct BeforeCleaning {
  std::vector<glm::vec3> positions;
  std::vector<glm::u16vec3> colors;  ///< empty if the cloud has none
  std::vector<Measured> measured;
};

/// Moves the points of a scanned cloud onto the surface that they are noisy samples of
/// (point_surface.h), gives them its normals, and removes points that no surface supports, such as
/// those between an edge and what lies behind it. Where there is much noise, colours become means
/// of those around them; radii and scalar fields stay.
///
/// The normals of the cloud tell its two sides apart; without normals they are estimated
/// (normals.h). The noise is estimated from the distances between points and surface. The radius of
/// support grows with the square root of noise times spacing, because a wider one averages more
/// noise away but flattens what is curved, and across gaps between scanned curves. The formulas are
/// in common/FORMULAS.md, "Noise and support".
///
/// Points stay where they are if a surface is only found across a gap, as in small clumps far from
/// each other, or if it is further away than the median radius.
///
/// Clouds that are no scans of surfaces stay as they are: fewer than 100 points, a scale at which
/// squares are no floats, more points without a surface around them than with one, points that are
/// repeated nearby, or noise that is none, such as that of a room that few rings of a lidar see.
///
/// The cloud's positions are finite (`sanitize`). The result depends neither on the order of the
/// points nor on the executor. O(n) for scans of surfaces.
CleanReport clean(PointCloud& cloud, const CleanOptions& options = {},
                  const Executor& executor = {}, BeforeCleaning* before = nullptr);

}  // namespace pointreel
