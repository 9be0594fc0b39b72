#include "datasets_synthetic/samplers/ldc.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "common/base/try.h"
#include "datasets_synthetic/ray_cast.h"

namespace pointreel {
namespace {

constexpr double kMaxRays = 2147483648.0;

/// The range of lattice points around a surface.
struct LatticeBox {
  glm::ivec3 first, last;
};

Result<LatticeBox> lattice_box(const Surface& surface, const Lattice& lattice) {
  const Box box = bounds(surface);
  const glm::dvec3 low = glm::floor((box.min - lattice.origin) / lattice.spacing);
  const glm::dvec3 high = glm::ceil((box.max - lattice.origin) / lattice.spacing);
  const glm::dvec3 reach = glm::max(glm::abs(low), glm::abs(high));
  const glm::dvec3 count = high - low + 1.0;
  const double rays = count.x * count.y + count.y * count.z + count.z * count.x;
  if (!(lattice.spacing > 0.0 && std::max({reach.x, reach.y, reach.z}) < kMaxRays / 2.0 &&
        rays < kMaxRays)) {
    return fail(
        ErrorCode::limit,
        fmt::format("cannot cast rays {} m apart at a surface of {:.3g} m: there would be "
                    "too many",
                    lattice.spacing, std::max({box.extent().x, box.extent().y, box.extent().z})));
  }
  return LatticeBox{glm::ivec3(low), glm::ivec3(high)};
}

/// Appends all hits of those rays along `axis` whose coordinate on the second-next axis is `row`.
void cast_row(const SurfaceGrid& grid, const Lattice& lattice, const LatticeBox& box, int axis,
              int row, std::vector<LatticeHit>& hits) {
  const int next = (axis + 1) % 3, after = (axis + 2) % 3;
  std::vector<RayHit> found;
  for (int i = box.first[next]; i <= box.last[next]; ++i) {
    glm::ivec3 cell(0);
    cell[axis] = box.first[axis];
    cell[next] = i;
    cell[after] = row;
    Ray ray{lattice.origin + lattice.spacing * glm::dvec3(cell), glm::dvec3(0.0)};
    ray.direction[axis] = 1.0;
    all_hits(grid, ray, found);
    for (const RayHit& hit : found) {
      const double along = (hit.position[axis] - lattice.origin[axis]) / lattice.spacing;
      cell[axis] = static_cast<int>(std::floor(along));
      hits.push_back({{hit.position, hit.normal, hit.primitive}, axis, cell});
    }
  }
}

/// The lattice point nearest to a hit, and its distance in units of the spacing.
struct Snapped {
  glm::ivec3 point;
  double moved;
};

Snapped snap(const Lattice& lattice, const LatticeHit& hit) {
  const int axis = hit.axis;
  const double along =
      (hit.point.position[axis] - lattice.origin[axis]) / lattice.spacing - hit.cell[axis];
  Snapped snapped{hit.cell, along};
  if (along >= 0.5) {
    ++snapped.point[axis];
    snapped.moved = 1.0 - along;
  }
  return snapped;
}

using BlockKey = std::array<int, 3>;
using PointKey = std::array<int, 3>;

BlockKey block_of(const glm::ivec3& p) {
  BlockKey key;
  for (int i = 0; i < 3; ++i) {
    const int down = p[2 - i] < 0 ? kLdcBlock - 1 : 0;
    key[static_cast<std::size_t>(i)] = (p[2 - i] - down) / kLdcBlock;
  }
  return key;
}

/// Appends the hits of one block: reduced, or unchanged where the structures are too thin for that.
void reduce_block(const Lattice& lattice, const std::vector<LatticeHit>& hits,
                  const std::vector<std::uint32_t>& members, std::vector<SurfacePoint>& points) {
  struct Candidate {
    PointKey key;
    double moved;
    std::uint32_t hit;
  };
  std::vector<Candidate> candidates;
  for (const std::uint32_t number : members) {
    const Snapped snapped = snap(lattice, hits[number]);
    const glm::ivec3& p = snapped.point;
    candidates.push_back({{p.z, p.y, p.x}, snapped.moved, number});
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.key, a.moved, a.hit) < std::tie(b.key, b.moved, b.hit);
  });
  const std::size_t before = points.size();
  const Candidate* kept = nullptr;
  for (const Candidate& candidate : candidates) {
    const SurfacePoint& point = hits[candidate.hit].point;
    if (kept != nullptr && kept->key == candidate.key) {
      if (glm::dot(hits[kept->hit].point.normal, point.normal) < 0.0) {
        points.resize(before);
        for (const std::uint32_t number : members) points.push_back(hits[number].point);
        return;
      }
      continue;
    }
    kept = &candidate;
    const glm::dvec3 place(candidate.key[2], candidate.key[1], candidate.key[0]);
    points.push_back({lattice.origin + lattice.spacing * place, point.normal, point.primitive});
  }
}

std::vector<SurfacePoint> reduce_to_one(const Lattice& lattice,
                                        const std::vector<LatticeHit>& hits) {
  std::map<BlockKey, std::vector<std::uint32_t>> blocks;
  for (std::uint32_t i = 0; i < hits.size(); ++i) {
    blocks[block_of(snap(lattice, hits[i]).point)].push_back(i);
  }
  std::vector<SurfacePoint> points;
  for (const auto& [key, members] : blocks) reduce_block(lattice, hits, members, points);
  return points;
}

}  // namespace

Result<std::vector<LatticeHit>> cast_lattice(const SurfaceGrid& grid, const Lattice& lattice) {
  const LatticeBox box = TRY(lattice_box(grid.surface(), lattice));
  std::vector<LatticeHit> hits;
  for (int axis = 0; axis < 3; ++axis) {
    const int after = (axis + 2) % 3;
    const int rows = box.last[after] - box.first[after] + 1;
    std::vector<std::vector<LatticeHit>> found(static_cast<std::size_t>(rows));
    tbb::parallel_for(0, rows, [&](int row) {
      cast_row(grid, lattice, box, axis, box.first[after] + row,
               found[static_cast<std::size_t>(row)]);
    });
    for (const auto& some : found) hits.insert(hits.end(), some.begin(), some.end());
  }
  return hits;
}

Result<std::vector<SurfacePoint>> sample_ldc(const SurfaceGrid& grid, const LdcOptions& options) {
  const Lattice lattice{glm::dvec3(0.0), options.spacing};
  const auto hits = TRY(cast_lattice(grid, lattice));
  if (options.reduce) return reduce_to_one(lattice, hits);
  std::vector<SurfacePoint> points;
  points.reserve(hits.size());
  for (const LatticeHit& hit : hits) points.push_back(hit.point);
  return points;
}

}  // namespace pointreel
