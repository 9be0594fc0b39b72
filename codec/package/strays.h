#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// The points, by their indices, that lie more than a hundred times as far from the middle of the
/// cloud as all others, which are at least three quarters of them: errors of sensors and programs.
/// They would take the octree's levels from what was to be seen. Empty if there are none, and if
/// points thin out gradually. O(n) unless the box is suspiciously large.
std::vector<std::size_t> find_strays(const PointCloud& cloud);

/// "point 400 at 1e+06 0 0 lies far from all others", for people. `numbered`: the indices are those
/// in the file.
std::string strays_text(const PointCloud& cloud, const std::vector<std::size_t>& strays,
                        bool numbered);

/// The same of a cloud, without indices; empty if there are no strays.
std::string strays_text(const PointCloud& cloud);

/// An error of which this text of strays tells the cause, if it is not empty.
Error blame(const std::string& strays, Error error);

/// The point that is farthest from the middle, as above; empty for an empty cloud.
std::string farthest_text(const PointCloud& cloud);

}  // namespace pointreel
