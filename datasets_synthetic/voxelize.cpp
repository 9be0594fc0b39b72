#include "datasets_synthetic/voxelize.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "codec/core/morton.h"
#include "codec/core/radix_sort.h"
#include "common/base/try.h"
#include "datasets_synthetic/samplers/ldc.h"

namespace pointreel {
namespace {

/// The keys of all voxels, sorted: each voxel once for each of its edges that meets the surface,
/// with the index of that hit.
std::vector<KeyIndex> voxels_of(const std::vector<LatticeHit>& hits, int bits) {
  const int last = (1 << bits) - 1;
  std::vector<KeyIndex> keys;
  keys.reserve(4 * hits.size());
  for (std::uint32_t i = 0; i < hits.size(); ++i) {
    const int next = (hits[i].axis + 1) % 3, after = (hits[i].axis + 2) % 3;
    for (int side = 0; side < 4; ++side) {
      glm::ivec3 cell = hits[i].cell;
      cell[next] -= side & 1;
      cell[after] -= side >> 1;
      cell = glm::clamp(cell, 0, last);  // rounding may place the surface just outside the grid
      keys.push_back({morton_encode(glm::uvec3(cell)), i});
    }
  }
  radix_sort(keys, 3 * bits);
  return keys;
}

}  // namespace

VoxelGrid voxel_grid(const Box& box, int bits) {
  const double last = static_cast<double>((1 << bits) - 1);
  const Cube cube = bounding_cube(box);
  return {cube.origin, cube.edge / last, bits};
}

Result<PointCloud> voxelize(const Body& body, const VoxelGrid& grid) {
  const auto surface = TRY(SurfaceGrid::build(body.surface));
  // The corners of the voxels are the points of the lattice.
  const auto hits = TRY(cast_lattice(surface, {grid.origin - 0.5 * grid.voxel, grid.voxel}));
  std::vector<glm::u8vec3> colors(hits.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const SurfacePoint& point = hits[i].point;
    colors[i] = color_at(body, point.primitive, point.position);
  }
  const std::vector<KeyIndex> keys = voxels_of(hits, grid.bits);
  PointCloud cloud;
  for (std::size_t begin = 0, end = 0; begin < keys.size(); begin = end) {
    glm::dvec3 normal(0.0);
    glm::uvec3 color(0u);
    for (; end < keys.size() && keys[end].key == keys[begin].key; ++end) {
      normal += hits[keys[end].index].point.normal;
      color += glm::uvec3(colors[keys[end].index]);
    }
    const auto count = static_cast<std::uint32_t>(end - begin);
    color = (color + count / 2u) / count;
    const double length = glm::length(normal);
    cloud.positions.emplace_back(morton_decode(keys[begin].key));
    cloud.normals.emplace_back(length > 0.0 ? normal / length : glm::dvec3(0.0));
    cloud.colors.push_back(glm::u16vec3(color) * std::uint16_t{257});
  }
  return cloud;
}

}  // namespace pointreel
