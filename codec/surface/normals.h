#pragma once

#include "pointreel/cloud.h"
#include "pointreel/executor.h"

namespace pointreel {

/// Estimates a unit normal for every point from its neighbours, and replaces the cloud's normals. A
/// normal is zero if it is unknown, because there are fewer than three distinct points around it or
/// all of them are on a line.
///
/// A plane is fitted to the points of each octree cell and its 26 neighbours, which are about 25
/// points (H. Hoppe et al., "Surface Reconstruction from Unorganized Points", 1992, section 3.2),
/// or to those of a coarser cell if there are too few. The normal of a point is blended from the
/// cells around it. Normals point to the more open side (openness.h), which is the outside of a
/// scanned body, even where its surface has holes and folds.
///
/// Accuracy: the median angle is 0.2 degrees for 90,000 random points on a sphere, and 0.5 degrees
/// on a torus of radii 1 and 0.3; all normals point outward. A cell and its neighbours are about
/// five spacings wide, and thinner detail is smoothed.
///
/// The cloud's positions are finite (`sanitize`). The result depends neither on their order nor on
/// the executor. O(n).
void estimate_normals(PointCloud& cloud, const Executor& executor = {});

/// The same, and estimates a radius for every point from the spacing of the points around it, which
/// takes little more time. The radius is the edge of a square of the surface that contains one
/// point, so that discs of this radius overlap about threefold. It is finite and above 0.
/// Duplicates count once.
void estimate_normals_and_radii(PointCloud& cloud, const Executor& executor = {});

/// Estimates the normals of points that have none, and keeps the others: as `estimate_normals`
/// does, or, of a few points, by the normals around each, if these agree.
void complete_normals(PointCloud& cloud, const Executor& executor = {});

/// Estimates the radius of every point whose radius is zero, which is how `sanitize` marks unusable
/// ones. No estimate exceeds the largest radius of the cloud. Does nothing if the cloud has no
/// radii.
void estimate_unknown_radii(PointCloud& cloud);

}  // namespace pointreel
