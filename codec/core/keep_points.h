#pragma once

#include <cstddef>

#include "pointreel/cloud.h"

namespace pointreel {

/// Removes the points i for which `keeps(i)` is false, from every array that the cloud has. The
/// others stay in their order. Returns how many were removed.
template <class Keeps>
std::size_t keep_points(PointCloud& cloud, const Keeps& keeps) {
  const std::size_t count = cloud.size();
  const bool normals = cloud.has_normals(), colors = cloud.has_colors(), radii = cloud.has_radii();
  std::size_t to = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!keeps(i)) continue;
    if (to != i) {
      cloud.positions[to] = cloud.positions[i];
      if (normals) cloud.normals[to] = cloud.normals[i];
      if (colors) cloud.colors[to] = cloud.colors[i];
      if (radii) cloud.radii[to] = cloud.radii[i];
      for (ScalarField& field : cloud.scalars) field.values[to] = field.values[i];
    }
    ++to;
  }
  cloud.positions.resize(to);
  if (normals) cloud.normals.resize(to);
  if (colors) cloud.colors.resize(to);
  if (radii) cloud.radii.resize(to);
  for (ScalarField& field : cloud.scalars) field.values.resize(to);
  return count - to;
}

}  // namespace pointreel
