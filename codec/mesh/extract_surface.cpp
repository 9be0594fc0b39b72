#include "codec/mesh/extract_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "codec/mesh/cell_patches.h"
#include "codec/mesh/point_blocks.h"
#include "common/base/for_each.h"

namespace pointreel {
namespace {

constexpr int kEdge = PointBlocks::kEdge;
constexpr std::size_t kCells = PointBlocks::kCells;
/// Samples further than this share of the reach from all points are no corners of cells with a
/// surface.
constexpr float kNear = 0.85f;
/// Between two samples, the distance changes by no more than the edge between them, unless they
/// belong to different sheets.
constexpr float kMostChange = 1.75f;
/// By how many cells a vertex moves from the middle of the crossings onto the surface.
constexpr float kMostMove = 0.9f;
/// A point alone has a weight of at most 1.
constexpr float kLeastWeight = 1.5f;
constexpr std::size_t kBlocksPerTask = 64;

/// The signed distance to the surface, in cells and negative inside, and the surface's normal. NaN
/// where there is no surface.
struct Sample {
  float distance = std::numeric_limits<float>::quiet_NaN();
  glm::vec3 normal{0.0f};
};
using Samples = std::array<Sample, kCells>;

/// What a cell has in the mesh.
struct Cell {
  std::uint32_t first_vertex = 0;  ///< of its patches, within the block
  std::uint8_t inside = 0;         ///< its corners, for cell_patches
};

struct Vertex {
  glm::vec3 place;  ///< relative to the block
  glm::vec3 normal;
  glm::u16vec3 color{0};
  float beside = 0.0f;
};

struct Block {
  std::unique_ptr<Samples> samples;  ///< null: there is no surface
  std::array<Cell, kCells> cells;
  std::vector<Vertex> vertices;
  std::uint32_t first_vertex = 0;  ///< in the mesh
  std::vector<glm::uvec3> triangles;
};

constexpr int cell_index(const glm::ivec3& at) { return at.x + kEdge * (at.y + kEdge * at.z); }

glm::ivec3 unit(int axis) {
  glm::ivec3 one(0);
  one[axis] = 1;
  return one;
}

class Extraction {
 public:
  Extraction(const GriddedCloud& points, const Executor& executor)
      : points_(points),
        executor_(executor),
        blocks_(points.cloud, points.grid, points.reaches, executor),
        all_(blocks_.size()) {}

  /// That the blocks may take, if all of them have a surface.
  std::uint64_t memory() const { return blocks_.size() * (sizeof(Block) + sizeof(Samples)); }

  UncutMesh run() {
    for_blocks([this](std::uint32_t block, LocalSurface& surface) { sample(block, surface); });
    for_blocks([this](std::uint32_t block, LocalSurface& surface) { place(block, surface); });
    std::uint32_t vertices = 0;
    for (const auto& block : all_) {
      if (!block) continue;
      block->first_vertex = vertices;
      vertices += static_cast<std::uint32_t>(block->vertices.size());
    }
    for_blocks([this](std::uint32_t block, LocalSurface&) { connect(block); });
    return gather();
  }

 private:
  template <class Work>
  void for_blocks(const Work& work) {
    const std::size_t tasks = (blocks_.size() + kBlocksPerTask - 1) / kBlocksPerTask;
    for_each(executor_, static_cast<int>(tasks), [&](int task) {
      LocalSurface surface(points_);
      const std::size_t begin = static_cast<std::size_t>(task) * kBlocksPerTask;
      for (std::size_t i = begin; i < std::min(begin + kBlocksPerTask, blocks_.size()); ++i)
        work(static_cast<std::uint32_t>(i), surface);
    });
  }

  void sample(std::uint32_t block, LocalSurface& surface) {
    surface.move_to(blocks_, block);
    std::unique_ptr<Samples> samples;
    for (std::size_t first = 0; first < kCells; first += kLanes) {
      Lanes x, y, z;
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const std::size_t i = first + lane;
        x[lane] = static_cast<float>(i % kEdge);
        y[lane] = static_cast<float>(i / kEdge % kEdge);
        z[lane] = static_cast<float>(i / kEdge / kEdge);
      }
      const NearestPoints nearest = surface.nearest(x, y, z);
      LaneMask wanted{};
      bool any = false;
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const float near = kNear * surface.reach_of(nearest.point[lane]);
        if (!(nearest.square[lane] <= near * near)) continue;
        wanted[lane] = -1;
        any = true;
      }
      if (!any) continue;
      const PlacesFound found = surface.fit(x, y, z, nearest, wanted).found;
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        if (!found.found[lane]) continue;
        if (!samples) samples = std::make_unique<Samples>();
        const glm::vec3 normal(found.nx[lane], found.ny[lane], found.nz[lane]);
        const glm::vec3 way(found.x[lane], found.y[lane], found.z[lane]);
        (*samples)[first + lane] = {-glm::dot(way, normal), normal};
      }
    }
    if (!samples) return;
    all_[block] = std::make_unique<Block>();
    all_[block]->samples = std::move(samples);
  }

  /// The blocks at `corner` and at the sides of it towards +1 or -1 along each axis: bit a of the
  /// index is set for those a block further along axis a.
  std::array<Block*, 8> around(std::uint32_t block, int towards) const {
    std::array<Block*, 8> found{};
    const glm::ivec3 corner = blocks_.corner(block);
    for (int i = 0; i < 8; ++i) {
      const glm::ivec3 step(i & 1, i >> 1 & 1, i >> 2 & 1);
      const std::uint32_t other = i == 0 ? block : blocks_.find(corner + towards * kEdge * step);
      found[i] = other == PointBlocks::kNone ? nullptr : all_[other].get();
    }
    return found;
  }

  static const Sample* sample_at(const std::array<Block*, 8>& blocks, const glm::ivec3& at) {
    const int further = (at.x >= kEdge ? 1 : 0) | (at.y >= kEdge ? 2 : 0) | (at.z >= kEdge ? 4 : 0);
    const Block* block = blocks[further];
    return block ? &(*block->samples)[cell_index(at & (kEdge - 1))] : nullptr;
  }

  /// Whether the surface crosses between two samples along an axis: they must belong to one sheet.
  static bool crosses(const Sample& a, const Sample& b, int axis) {
    if (!((a.distance < 0.0f) != (b.distance < 0.0f))) return false;
    const float change = b.distance - a.distance;
    const float slope = a.normal[axis] + b.normal[axis];
    return std::abs(change) < kMostChange && (change > 0.0f ? slope : -slope) > -0.2f;
  }

  void place(std::uint32_t number, LocalSurface& surface) {
    Block* block = all_[number].get();
    if (!block) return;
    const std::array<Block*, 8> blocks = around(number, 1);
    for (std::size_t i = 0; i < kCells; ++i) {
      const glm::ivec3 at(i % kEdge, i / kEdge % kEdge, i / kEdge / kEdge);
      std::array<const Sample*, 8> corners;
      std::uint8_t inside = 0;
      bool known = true;
      for (int c = 0; c < 8 && known; ++c) {
        corners[c] = sample_at(blocks, at + glm::ivec3(c & 1, c >> 1 & 1, c >> 2 & 1));
        known = corners[c] && !std::isnan(corners[c]->distance);
        if (known && corners[c]->distance < 0.0f)
          inside = static_cast<std::uint8_t>(inside | 1 << c);
      }
      if (!known || inside == 0 || inside == 255) continue;
      Cell& cell = block->cells[i];
      cell = {static_cast<std::uint32_t>(block->vertices.size()), inside};
      add_vertices(at, corners, cell_patches(inside), block->vertices);
    }
    if (block->vertices.empty()) return;
    surface.move_to(blocks_, number);
    settle(surface, block->vertices);
  }

  static void add_vertices(const glm::ivec3& at, const std::array<const Sample*, 8>& corners,
                           const CellPatches& patches, std::vector<Vertex>& vertices) {
    for (int patch = 0; patch < patches.count; ++patch) {
      glm::vec3 sum(0.0f), normal(0.0f);
      float count = 0.0f;
      for (int edge = 0; edge < 12; ++edge) {
        if (patches.of[edge] != patch) continue;
        const auto [first, second] = edge_corners(edge);
        const Sample &a = *corners[first], &b = *corners[second];
        const float t = a.distance / (a.distance - b.distance);
        glm::vec3 crossing(first & 1, first >> 1 & 1, first >> 2 & 1);
        crossing[edge / 4] += t;
        sum += crossing;
        normal += (1.0f - t) * a.normal + t * b.normal;
        count += 1.0f;
      }
      const float length = glm::length(normal);
      vertices.push_back({glm::vec3(at) + sum / count,
                          length > 0.0f ? normal / length : glm::vec3(0.0f, 0.0f, 1.0f)});
    }
  }

  /// Moves the vertices of a block onto the surface.
  void settle(const LocalSurface& surface, std::vector<Vertex>& vertices) const {
    for (std::size_t first = 0; first < vertices.size(); first += kLanes) {
      const std::size_t count = std::min(kLanes, vertices.size() - first);
      Lanes x{}, y{}, z{};
      LaneMask wanted{};
      for (std::size_t lane = 0; lane < count; ++lane) {
        const glm::vec3& at = vertices[first + lane].place;
        x[lane] = at.x;
        y[lane] = at.y;
        z[lane] = at.z;
        wanted[lane] = -1;
      }
      SurfaceFits fits = surface.fit(x, y, z, surface.nearest(x, y, z), wanted);
      surface.measure_beside(fits);
      for (std::size_t lane = 0; lane < count; ++lane) {
        Vertex& vertex = vertices[first + lane];
        const PlacesFound& found = fits.found;
        const glm::vec3 way(found.x[lane], found.y[lane], found.z[lane]);
        vertex.beside = 2.0f;
        if (found.found[lane] && fits.weight[lane] > kLeastWeight &&
            glm::dot(way, way) <= kMostMove * kMostMove) {
          vertex.place += way;
          vertex.normal = glm::vec3(found.nx[lane], found.ny[lane], found.nz[lane]);
          vertex.beside = fits.beside[lane];
        }
        if (points_.cloud.has_colors()) vertex.color = surface.color(vertex.place, vertex.normal);
      }
    }
  }

  void connect(std::uint32_t number) {
    Block* block = all_[number].get();
    if (!block) return;
    const std::array<Block*, 8> after = around(number, 1), before = around(number, -1);
    for (std::size_t i = 0; i < kCells; ++i) {
      const glm::ivec3 at(i % kEdge, i / kEdge % kEdge, i / kEdge / kEdge);
      const Sample& here = (*block->samples)[i];
      if (std::isnan(here.distance)) continue;
      for (int axis = 0; axis < 3; ++axis) {
        const Sample* there = sample_at(after, at + unit(axis));
        if (!there || std::isnan(there->distance) || !crosses(here, *there, axis)) continue;
        const glm::ivec3 b = unit((axis + 1) % 3), c = unit((axis + 2) % 3);
        std::array<std::pair<std::uint32_t, const Vertex*>, 4> ring{};
        bool complete = true;
        // Counter-clockwise around the edge, as seen from its end.
        constexpr std::array<int, 4> kRing = {0, 1, 3, 2};
        for (int k = 0; k < 4 && complete; ++k) {
          const int side = kRing[k];
          ring[k] = vertex_of(before, at - (side & 1) * b - (side >> 1) * c, 4 * axis + side);
          complete = ring[k].second != nullptr;
        }
        if (!complete) continue;
        if (here.distance >= 0.0f) std::swap(ring[1], ring[3]);
        split(ring, block->triangles);
      }
    }
  }

  /// The vertex of the patch that an edge of a cell belongs to, with its number in the mesh.
  static std::pair<std::uint32_t, const Vertex*> vertex_of(const std::array<Block*, 8>& blocks,
                                                           const glm::ivec3& at, int edge) {
    const int further = (at.x < 0 ? 1 : 0) | (at.y < 0 ? 2 : 0) | (at.z < 0 ? 4 : 0);
    const Block* block = blocks[further];
    if (!block) return {};
    const Cell& cell = block->cells[cell_index(at & (kEdge - 1))];
    const std::uint8_t patch = cell_patches(cell.inside).of[edge];
    if (patch == CellPatches::kNone) return {};
    const std::uint32_t vertex = cell.first_vertex + patch;
    return {block->first_vertex + vertex, &block->vertices[vertex]};
  }

  /// Two triangles, along the diagonal whose ends face the same way more.
  static void split(const std::array<std::pair<std::uint32_t, const Vertex*>, 4>& ring,
                    std::vector<glm::uvec3>& triangles) {
    const auto bend = [&](int a, int b) {
      return glm::dot(ring[a].second->normal, ring[b].second->normal);
    };
    const std::uint32_t v0 = ring[0].first, v1 = ring[1].first, v2 = ring[2].first,
                        v3 = ring[3].first;
    if (bend(0, 2) >= bend(1, 3)) {
      triangles.emplace_back(v0, v1, v2);
      triangles.emplace_back(v0, v2, v3);
    } else {
      triangles.emplace_back(v0, v1, v3);
      triangles.emplace_back(v1, v2, v3);
    }
  }

  UncutMesh gather() {
    UncutMesh uncut;
    PointCloud& vertices = uncut.mesh.vertices;
    vertices.origin = points_.cloud.origin;
    for (std::uint32_t i = 0; i < all_.size(); ++i) {
      const Block* block = all_[i].get();
      if (!block) continue;
      const glm::dvec3 corner(blocks_.corner(i));
      for (const Vertex& vertex : block->vertices) {
        vertices.positions.emplace_back(points_.grid.outside(corner + glm::dvec3(vertex.place)));
        vertices.normals.push_back(vertex.normal);
        if (points_.cloud.has_colors()) vertices.colors.push_back(vertex.color);
        uncut.beside.push_back(vertex.beside);
      }
      uncut.mesh.triangles.insert(uncut.mesh.triangles.end(), block->triangles.begin(),
                                  block->triangles.end());
    }
    return uncut;
  }

  const GriddedCloud& points_;
  const Executor& executor_;
  PointBlocks blocks_;
  std::vector<std::unique_ptr<Block>> all_;
};

}  // namespace

Result<UncutMesh> extract_surface(const GriddedCloud& points, std::uint64_t max_memory,
                                  const Executor& executor) {
  const auto too_much = [](std::uint64_t memory) {
    return fail(ErrorCode::limit,
                fmt::format("a mesh would take about {} MiB of memory", memory >> 20));
  };
  const std::uint64_t seen = PointBlocks::memory(points.reaches);
  if (seen > max_memory) return too_much(seen);
  Extraction extraction(points, executor);
  if (extraction.memory() > max_memory) return too_much(extraction.memory());
  return extraction.run();
}

}  // namespace pointreel
