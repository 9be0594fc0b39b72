#include "codec/max_error.h"

#include <algorithm>
#include <cmath>

namespace pointreel {

double max_geometry_error(const Cube& cube, int depth) {
  double farthest = cube.edge;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = cube.origin[axis];
    farthest = std::max({farthest, std::abs(low), std::abs(low + cube.edge)});
  }
  const double half_cell = std::ldexp(cube.edge, -depth - 1);
  const double to_float = std::ldexp(cube.edge, -24);
  // A few operations, each off by half a unit in the last place: the difference of two origins, its
  // sum with a position, the product with the number of cells per unit, and the way back.
  const double in_double = std::ldexp(farthest, -50);
  return std::sqrt(3.0) * (half_cell + to_float + in_double);
}

}  // namespace pointreel
