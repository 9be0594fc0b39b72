#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <glm/glm.hpp>

#include "pointreel/cloud.h"
#include "pointreel/error.h"

/// How far two clouds lie apart, in geometry, colours and normals: the metrics of MPEG's pc_error
/// (D. Tian et al., "Geometric distortion metrics for point cloud compression", ICIP 2017).
///
/// A point is compared with its nearest neighbour in the other cloud, or with the mean over all
/// that are as near (pc_error's default): those whose distances differ by no more than the rounding
/// of the coordinates to float. A point between eight voxels is common, and to pick one of them
/// would be noise. Points of one cloud at the same position count as one neighbour with their mean
/// attributes, but each asks for its own.
namespace pointreel {

/// Angles in radians between the normals of points and those of their neighbours. Normals that
/// point in opposite directions are pi apart.
struct AngleError {
  double mean = 0.0;
  double percentile_95 = 0.0;
  std::size_t unknown = 0;  ///< pairs that were left out since one has no normal
};

/// Mean squared differences of colour in Y', Cb, Cr: BT.709 of sRGB values, full range, in units of
/// 8-bit steps.
using ColorError = glm::dvec3;

/// From the points of one cloud to their nearest neighbours in another. What depends on an
/// attribute that is missing, or unknown everywhere, is absent.
struct OneWayDistance {
  double mean_squared = 0.0;  ///< D1: of |a - b|
  double max = 0.0;
  /// D2: mean of ((a - b) . n)^2, n the normal at b. The normals are those of the first cloud
  /// alone, as in pc_error, so that an error of the second's normals is not taken for one of
  /// geometry; if only the second has normals, it lends them. A point without normals takes the
  /// mean direction of those points' that have it as their neighbour, or else of its own
  /// neighbours.
  std::optional<double> plane_mean_squared;
  std::size_t plane_unknown = 0;  ///< points left out of it: nothing near has a normal
  std::optional<ColorError> colors;
  std::optional<AngleError> normals;  ///< of each cloud's own normals
};

/// The error between two clouds, in the units of their coordinates. Symmetric values are the worse
/// of the two directions.
struct CloudDistance {
  OneWayDistance a_to_b;
  OneWayDistance b_to_a;

  double d1() const;                 ///< squared units
  std::optional<double> d2() const;  ///< squared units
  double max() const;                ///< the largest distance of all (symmetric Hausdorff)
  std::optional<ColorError> colors() const;
  std::optional<AngleError> normals() const;
};

/// Peak signal-to-noise ratio in dB, 10 log10(3 peak^2 / mean_squared), of D1 and D2: `peak` is the
/// largest coordinate of the source's grid, 2^bits - 1 of its cells, in the units of the clouds.
/// Infinite where there is no error.
double geometry_psnr(double mean_squared, double peak);

/// 10 log10(255^2 / mean_squared) of each component, in dB.
glm::dvec3 color_psnr(const ColorError& mean_squared);

/// Compares two clouds in world coordinates, each relative to a common origin in double, with an
/// exact nearest-neighbour search (k-d tree), in parallel (TBB's threads); the result does not
/// depend on their number. 800,000 points against as many with all attributes take 0.6 s on two
/// cores. An error if either cloud is empty; positions are finite.
Result<CloudDistance> cloud_distance(const PointCloud& a, const PointCloud& b);

/// What is told of many distances.
struct DistanceSummary {
  double mean = 0.0;
  double percentile_95 = 0.0;  ///< no less than 95 % of all are no larger (nearest rank)
  double percentile_999 = 0.0;
  double max = 0.0;
};

/// All zero if there are none.
DistanceSummary summarize(std::span<const double> distances);

}  // namespace pointreel
