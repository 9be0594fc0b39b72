#include "client/render/software/triangles.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "client/render/software/flat_light.h"
#include "client/render/software/lanes.h"
#include "client/strips/each_triangle.h"
#include "common/base/for_each.h"
#include "pointreel/cpu.h"

namespace pointreel {
namespace {

constexpr std::uint32_t kNothing = ~0u;
/// A triangle's number: that of its block, and its place in the block.
constexpr std::uint32_t kPlaceBits = 14;
/// Ranges of indices are put into a block until it has this many; a range has less than as many
/// again.
constexpr std::size_t kIndices = 4096;

/// Triangles reach this far beyond their edges, in pixels, so that rounding leaves no cracks
/// between neighbours.
constexpr float kReach = 1.0f / 256.0f;

/// The first pixel whose centre is not below a coordinate, and the first that is above it, both cut
/// off at the picture.
std::int16_t first_from(float v, float size) {
  const float at = v > 0.5f ? (v < size ? v - 0.5f : size) : 0.0f;
  const int whole = static_cast<int>(at);
  return static_cast<std::int16_t>(whole + (static_cast<float>(whole) < at ? 1 : 0));
}
std::int16_t first_beyond(float v, float size) {
  return static_cast<std::int16_t>(v > 0.0f ? (v < size ? v + 0.5f : size) : 0.0f);
}

/// The shares of the first two vertices of a triangle in a point of the window; that of the third
/// is what is missing to 1.
struct Shares {
  float x, y;        ///< the third vertex
  float ax, ay;      ///< gradient of the first's share
  float bx, by;      ///< of the second's
  float ra, rb, rc;  ///< how much they change over kReach pixels, across the opposite edge

  /// Empty triangles get no shares that are numbers.
  template <class Vertex>
  POINTREEL_INLINE Shares(const Vertex& a, const Vertex& b, const Vertex& c) : x(c.x), y(c.y) {
    const float scale = 1.0f / ((a.x - c.x) * (b.y - c.y) - (a.y - c.y) * (b.x - c.x));
    ax = scale * (b.y - c.y);
    ay = scale * (c.x - b.x);
    bx = scale * (c.y - a.y);
    by = scale * (a.x - c.x);
    const auto reach = [](float u, float v) { return kReach * (std::abs(u) + std::abs(v)); };
    ra = reach(ax, ay);
    rb = reach(bx, by);
    rc = reach(ax + bx, ay + by);
  }
};

}  // namespace

struct Triangles::Tile {
  PixelRect pixels;
  TilePlane depth;
  std::array<std::uint32_t, std::tuple_size_v<TilePlane>> triangles;
};

/// Shares the ranges and the points out into blocks; returns how many there are.
std::size_t Triangles::divide(const SceneStrips& strips, Backs backs) {
  std::size_t count = 0;
  const auto next = [&]() -> Block& {
    if (blocks_.size() == count) blocks_.emplace_back();
    Block& block = blocks_[count++];
    block.part = nullptr;
    block.ranges = {};
    block.first_point = block.end_point = 0;
    return block;
  };
  for (const SceneStrips::Part& part : strips.parts()) {
    if (part.strips == nullptr) continue;
    for (const auto* list : {&part.cut.facing, &part.cut.mixed, &part.cut.turned_away}) {
      if (list == &part.cut.turned_away && backs == Backs::none) continue;
      const std::span<const StripCut::Range> ranges(*list);
      for (std::size_t begin = 0, end = 0; begin < ranges.size(); begin = end) {
        for (std::size_t indices = 0; end < ranges.size() && indices < kIndices; ++end)
          indices += ranges[end].count;
        Block& block = next();
        block.part = &part;
        block.ranges = ranges.subspan(begin, end - begin);
      }
    }
  }
  for (std::size_t begin = 0; begin < strips.points().size(); begin += kIndices) {
    Block& block = next();
    block.first_point = begin;
    block.end_point = std::min(begin + kIndices, strips.points().size());
  }
  return count;
}

void Triangles::project(std::span<const Instance> vertices, const PictureView& view,
                        std::vector<Projected>& to, const Executor& executor) const {
  constexpr std::size_t kBlock = 8192;
  if (to.size() < vertices.size()) to.resize(vertices.size());
  const glm::mat4& m = view.to_clip;
  const glm::vec2 half = 0.5f * glm::vec2(view.window);
  const float near = view.eye.w;
  for_each(executor, static_cast<int>((vertices.size() + kBlock - 1) / kBlock), [&](int block) {
    const std::size_t begin = static_cast<std::size_t>(block) * kBlock;
    for (std::size_t i = begin; i < std::min(begin + kBlock, vertices.size()); ++i) {
      const glm::vec3& p = vertices[i].center;
      const float x = m[0][0] * p.x + m[1][0] * p.y + m[2][0] * p.z + m[3][0],
                  y = m[0][1] * p.x + m[1][1] * p.y + m[2][1] * p.z + m[3][1],
                  w = m[0][3] * p.x + m[1][3] * p.y + m[2][3] * p.z + m[3][3];
      const float by = 1.0f / w;
      to[i] = {half.x + half.x * x * by, half.y + half.y * y * by, w >= near ? near * by : 0.0f};
    }
  });
}

void Triangles::set_up(Backs backs, const PictureView& view, Block& block) const {
  std::size_t most = block.end_point - block.first_point;
  for (const StripCut::Range& range : block.ranges) most += range.count;
  // One more, because a triangle is written before it is decided whether it stays.
  if (block.triangles.size() < most + 1) block.triangles.resize(most + 1);
  Triangle* out = block.triangles.data();

  const glm::vec2 size(view.window);
  for (std::size_t i = block.first_point; i < block.end_point; ++i) {
    const Projected& at = points_[i];
    if (!(at.depth > 0.0f && at.x >= 0.0f && at.y >= 0.0f && at.x < size.x && at.y < size.y))
      continue;
    const auto x = static_cast<std::int16_t>(at.x), y = static_cast<std::int16_t>(at.y);
    const auto number = static_cast<std::uint32_t>(i);
    *out++ = {number,
              number,
              number,
              false,
              {x, y, static_cast<std::int16_t>(x + 1), static_cast<std::int16_t>(y + 1)}};
  }

  const bool signs_unknown = view.pixel.y > 0.5f, keep_backs = backs == Backs::depth;
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const Projected &p = projected_[a], &q = projected_[b], &r = projected_[c];
    const float area = (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
    const float left = std::min(std::min(p.x, q.x), r.x), right = std::max(std::max(p.x, q.x), r.x),
                low = std::min(std::min(p.y, q.y), r.y), high = std::max(std::max(p.y, q.y), r.y);
    const TileRect rect{first_from(left - kReach, size.x), first_from(low - kReach, size.y),
                        first_beyond(right + kReach, size.x), first_beyond(high + kReach, size.y)};
    const bool is_back = area < 0.0f && !signs_unknown;
    *out = {a, b, c, is_back, rect};
    // Without branches, whose outcome no processor could predict.
    const bool in_front = std::min(std::min(p.depth, q.depth), r.depth) > 0.0f;
    const int stays = static_cast<int>(rect.x0 < rect.x1) & static_cast<int>(rect.y0 < rect.y1) &
                      static_cast<int>(area != 0.0f) & static_cast<int>(!is_back | keep_backs) &
                      static_cast<int>(in_front);
    out += stays;
  };
  for (const StripCut::Range& range : block.ranges) {
    const std::uint32_t first = block.part->first_vertex;
    each_triangle(std::span(block.part->strips->indices).subspan(range.first, range.count),
                  [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
                    add(a + first, b + first, c + first);
                  });
  }
  block.count = static_cast<std::size_t>(out - block.triangles.data());
}

namespace {

template <class Vertex>
POINTREEL_INLINE void fill(const Vertex& a, const Vertex& b, const Vertex& c, const TileRect& rect,
                           std::uint32_t number, const PixelRect& pixels, float* depths,
                           std::uint32_t* numbers) {
  const int x0 = std::max<int>(rect.x0, pixels.min.x), x1 = std::min<int>(rect.x1, pixels.max.x),
            y0 = std::max<int>(rect.y0, pixels.min.y), y1 = std::min<int>(rect.y1, pixels.max.y);
  const Shares shares(a, b, c);
  const float nearest = std::max(std::max(a.depth, b.depth), c.depth),
              farthest = std::min(std::min(a.depth, b.depth), c.depth);
  const float da = a.depth - c.depth, db = b.depth - c.depth;
  for (int y = y0; y < y1; ++y) {
    const float v = static_cast<float>(y) + 0.5f - shares.y;
    for (int x = x0; x < x1; x += kLaneStep) {
      const Lanes u = kIota + (static_cast<float>(x) + 0.5f - shares.x);
      const Lanes of_a = u * shares.ax + v * shares.ay, of_b = u * shares.bx + v * shares.by;
      const Lanes of_c = 1.0f - of_a - of_b;
      const Lanes depth =
          min_of(max_of(c.depth + of_a * da + of_b * db, Lanes{} + farthest), Lanes{} + nearest);
      const auto at = static_cast<std::size_t>((y - pixels.min.y) * kTileStride + x - pixels.min.x);
      Lanes old;
      load(old, depths + at);
      // The lanes beyond the rectangle may belong to it as far as the triangle knows.
      const LaneMask visible =
          (of_a >= -shares.ra) & (of_b >= -shares.rb) & (of_c >= -shares.rc) & (depth > old);
      store(depths + at, visible ? depth : old);
      LaneMask kept;
      std::memcpy(&kept, numbers + at, sizeof(kept));
      kept = visible ? LaneMask{} + static_cast<std::int32_t>(number) : kept;
      std::memcpy(numbers + at, &kept, sizeof(kept));
    }
  }
}

}  // namespace

void Triangles::draw_tile(std::size_t number, int tile, Tile& to) const {
  struct Kernels {
    static void portable(const Triangles& all, std::size_t block, int tile, Tile& to) {
      run(all, block, tile, to);
    }
    POINTREEL_AVX2 static void avx2(const Triangles& all, std::size_t block, int tile, Tile& to) {
      run(all, block, tile, to);
    }
    POINTREEL_INLINE static void run(const Triangles& all, std::size_t number, int tile, Tile& to) {
      const Block& block = all.blocks_[number];
      for (const std::uint16_t* i = block.bins.begin(tile); i != block.bins.end(tile); ++i) {
        const Triangle& triangle = block.triangles[*i];
        const auto id = static_cast<std::uint32_t>(number << kPlaceBits) | *i;
        if (triangle.a != triangle.b) {
          fill(all.projected_[triangle.a], all.projected_[triangle.b], all.projected_[triangle.c],
               triangle.rect, id, to.pixels, to.depth.data(), to.triangles.data());
          continue;
        }
        const auto at =
            static_cast<std::size_t>((triangle.rect.y0 - to.pixels.min.y) * kTileStride +
                                     triangle.rect.x0 - to.pixels.min.x);
        const float depth = all.points_[triangle.a].depth;
        if (!(depth > to.depth[at])) continue;
        to.depth[at] = depth;
        to.triangles[at] = id;
      }
    }
  };
  const bool avx2 = (cpu_features() & kCpuAvx2) != 0;
  (avx2 ? Kernels::avx2 : Kernels::portable)(*this, number, tile, to);
}

namespace {

/// What a pixel shows of vertices.
struct Fragment {
  glm::vec3 color{0.0f}, normal{0.0f}, from_eye{0.0f};

  void add(const Instance& vertex, float share, const PictureView& view) {
    color += share * color_of_instance(vertex);
    const glm::vec3 n(vertex.normal), to_vertex = vertex.center - glm::vec3(view.eye);
    const bool turned = view.pixel.y > 0.5f && glm::dot(n, to_vertex) > 0.0f;
    normal += (turned ? -share : share) / 32767.0f * n;
    from_eye += share * to_vertex;
  }

  glm::vec3 unit_normal(const PictureView& view) const {
    const float n2 = glm::dot(normal, normal);
    const float length = glm::length(from_eye);
    return n2 > 1e-3f      ? normal / std::sqrt(n2)
           : length > 0.0f ? -from_eye / length
                           : glm::vec3(view.light);
  }
};

}  // namespace

void Triangles::draw(std::span<const Instance> vertices, const SceneStrips& strips, Backs backs,
                     const PictureView& view, const Executor& executor, Picture& picture) {
  project(vertices, view, projected_, executor);
  project(strips.points(), view, points_, executor);
  const std::size_t count = divide(strips, backs);
  for_each(executor, static_cast<int>(count), [&](int i) {
    Block& block = blocks_[static_cast<std::size_t>(i)];
    set_up(backs, view, block);
    block.bins.sort(block.count, picture.grid,
                    [&](std::size_t k) { return block.triangles[k].rect; });
  });
  const SrgbTables& srgb = SrgbTables::get();
  for_each(executor, picture.grid.count(), [&](int number) {
    Tile tile;
    bool any = false;
    for (std::size_t i = 0; i < count; ++i) {
      const TileBins& bins = blocks_[i].bins;
      if (bins.begin(number) == bins.end(number)) continue;
      if (!any) {
        tile.pixels = picture.grid.pixels(number);
        tile.depth.fill(0.0f);
        tile.triangles.fill(kNothing);
        any = true;
      }
      draw_tile(i, number, tile);
    }
    if (!any) return;
    picture.busy[static_cast<std::size_t>(number)] = 1;
    for (int y = tile.pixels.min.y; y < tile.pixels.max.y; ++y) {
      for (int x = tile.pixels.min.x; x < tile.pixels.max.x; ++x) {
        const auto at =
            static_cast<std::size_t>((y - tile.pixels.min.y) * kTileStride + x - tile.pixels.min.x);
        const std::uint32_t id = tile.triangles[at];
        if (id == kNothing) continue;
        const Triangle& triangle =
            blocks_[id >> kPlaceBits].triangles[id & ((1u << kPlaceBits) - 1u)];
        const std::size_t to = picture.index(x, y);
        picture.depths[to] = tile.depth[at];
        if (triangle.is_back) continue;
        Fragment fragment;
        if (triangle.a == triangle.b) {
          fragment.add(strips.points()[triangle.a], 1.0f, view);
        } else {
          const Projected &a = projected_[triangle.a], &b = projected_[triangle.b],
                          &c = projected_[triangle.c];
          const Shares shares(a, b, c);
          const float u = static_cast<float>(x) + 0.5f - shares.x,
                      v = static_cast<float>(y) + 0.5f - shares.y;
          const auto bounded = [](float share) { return std::clamp(share, 0.0f, 1.0f); };
          const float of_a = bounded(u * shares.ax + v * shares.ay),
                      of_b = bounded(u * shares.bx + v * shares.by),
                      of_c = bounded(1.0f - of_a - of_b);
          // In space, what is nearer has a larger share than in the picture.
          const float wa = of_a * a.depth, wb = of_b * b.depth, wc = of_c * c.depth;
          const float scale = 1.0f / (wa + wb + wc);
          fragment.add(vertices[triangle.a], scale * wa, view);
          fragment.add(vertices[triangle.b], scale * wb, view);
          fragment.add(vertices[triangle.c], scale * wc, view);
        }

        const glm::vec3 normal = fragment.unit_normal(view);
        if (!picture.normals.empty()) picture.normals[to] = normal;
        picture.colors[to] = srgb.encode(fragment.color * light_on(normal, view), kDrawn);
      }
    }
  });
}

}  // namespace pointreel
