#include "codec/video_encode/view_layers.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numeric>
#include <optional>
#include <tuple>

#include "codec/video_encode/filter_points.h"
#include "common/base/for_each.h"

namespace pointreel {
namespace {

constexpr int kPasses = 3;
/// Points of neighbouring pixels hang together up to this difference of depth.
constexpr float kJump = 3.0f;
/// Patches of fewer points are left for the next pass, and then out.
constexpr std::size_t kSmallest = 64, kSmallestAgain = 16;
/// Layers are planned in blocks of so many pixels: what shares one should have similar depth, since
/// video codes it as one.
constexpr int kPlan = 4;
constexpr float kSameBlock = 6.0f, kNearBlock = 16.0f;

/// Sums of depth in the blocks of a layer.
struct BlockSums {
  struct Block {
    float sum = 0.0f, count = 0.0f;
    float mean() const { return sum / count; }
  };
  int side = 0;
  std::vector<Block> blocks;

  explicit BlockSums(int pixels)
      : side((pixels + kPlan - 1) / kPlan),
        blocks(static_cast<std::size_t>(side) * static_cast<std::size_t>(side)) {}
  BlockSums(int pixels, const ViewLayer& layer) : BlockSums(pixels) {
    layer.for_each([&](int x, int y, float depth) {
      Block& block = blocks[static_cast<std::size_t>(y / kPlan * side + x / kPlan)];
      block.sum += depth;
      ++block.count;
    });
  }

  std::size_t of_pixel(std::size_t pixel, std::size_t pixels) const {
    return pixel / pixels / kPlan * static_cast<std::size_t>(side) + pixel % pixels / kPlan;
  }
  void add(std::size_t pixel, std::size_t pixels, float depth) {
    Block& block = blocks[of_pixel(pixel, pixels)];
    block.sum += depth;
    ++block.count;
  }
};

/// The sets of points that hang together.
class Unions {
 public:
  explicit Unions(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::uint32_t find(std::uint32_t a) {
    while (parent_[a] != a) a = parent_[a] = parent_[parent_[a]];
    return a;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

constexpr std::uint32_t kNowhere = ~0u;

/// A pixel of a patch: of its points, the outermost.
struct PatchPixel {
  std::uint32_t pixel;
  float depth;
};

/// Lays what belongs to one view.
class OneView {
 public:
  OneView(const SurfacePoints& points, int view, const std::array<ViewLayer, kViewLayers>* before,
          std::array<ViewLayer, kViewLayers>& layers)
      : points_(points),
        axes_(kViewAxes[static_cast<std::size_t>(view)]),
        layers_(layers),
        pixels_(static_cast<std::size_t>(points.side)) {
    sums_of_patch_.resize(BlockSums(points.side).blocks.size());
    for (int l = 0; l < kViewLayers; ++l) {
      sums_.emplace_back(points.side);
      if (before != nullptr)
        before_.emplace_back(points.side, (*before)[static_cast<std::size_t>(l)]);
    }
  }

  /// Lays points of this view, which are in the order of their pixels and then of their depth.
  void lay(const std::vector<std::uint32_t>& points, bool again) {
    for (const std::vector<PatchPixel>& patch :
         patches_of(points, again ? kSmallestAgain : kSmallest)) {
      const auto [layer, cost] = cheapest(patch);
      if (again && cost > 0.5f * static_cast<float>(plan_.size())) continue;
      put(patch, layer);
    }
  }

 private:
  float depth_of(std::uint32_t point) const { return points_.places[point][axes_.depth]; }

  /// Patches from large to small.
  std::vector<std::vector<PatchPixel>> patches_of(const std::vector<std::uint32_t>& order,
                                                  std::size_t smallest) {
    // The pixels that have some of the points, where these begin, and where each pixel is found.
    std::vector<std::uint32_t> pixels, begin;
    for (std::uint32_t i = 0; i < order.size(); ++i) {
      const auto pixel = static_cast<std::uint32_t>(points_.pixel_of(order[i], axes_));
      if (!pixels.empty() && pixels.back() == pixel) continue;
      pixels.push_back(pixel);
      begin.push_back(i);
    }
    begin.push_back(static_cast<std::uint32_t>(order.size()));
    number_.resize(pixels_ * pixels_, kNowhere);
    for (std::uint32_t n = 0; n < pixels.size(); ++n) number_[pixels[n]] = n;

    Unions unions(order.size());
    const auto join = [&](std::uint32_t i, std::uint32_t j) {
      if (std::abs(depth_of(order[i]) - depth_of(order[j])) <= kJump) unions.join(i, j);
    };
    const int side = points_.side;
    for (std::uint32_t n = 0; n < pixels.size(); ++n) {
      // Neighbours in depth are enough: what lies between them hangs together with either.
      for (std::uint32_t i = begin[n] + 1; i < begin[n + 1]; ++i) join(i - 1, i);
      const int x = static_cast<int>(pixels[n]) % side, y = static_cast<int>(pixels[n]) / side;
      constexpr int kRight[] = {1, 0, 1, -1}, kDown[] = {0, 1, 1, 1};
      for (int k = 0; k < 4; ++k) {
        if (x + kRight[k] < 0 || x + kRight[k] >= side || y + kDown[k] >= side) continue;
        const std::uint32_t other =
            number_[pixels[n] + static_cast<std::size_t>(kDown[k] * side + kRight[k])];
        if (other == kNowhere) continue;
        std::uint32_t j = begin[other];
        for (std::uint32_t i = begin[n]; i < begin[n + 1]; ++i) {
          while (j < begin[other + 1] && depth_of(order[j]) < depth_of(order[i])) ++j;
          if (j < begin[other + 1]) join(i, j);
          if (j > begin[other]) join(i, j - 1);
        }
      }
    }
    for (const std::uint32_t pixel : pixels) number_[pixel] = kNowhere;

    std::vector<std::uint32_t> size(order.size(), 0);
    for (std::uint32_t i = 0; i < order.size(); ++i) ++size[unions.find(i)];
    std::vector<std::uint32_t> roots;
    for (std::uint32_t i = 0; i < order.size(); ++i)
      if (size[i] >= smallest) roots.push_back(i);
    std::sort(roots.begin(), roots.end(),
              [&](auto a, auto b) { return size[a] != size[b] ? size[a] > size[b] : a < b; });
    std::vector<std::uint32_t> place(order.size(), 0);
    for (std::uint32_t k = 0; k < roots.size(); ++k) place[roots[k]] = k + 1;
    std::vector<std::vector<PatchPixel>> patches(roots.size());
    for (std::uint32_t n = 0; n < pixels.size(); ++n) {
      for (std::uint32_t i = begin[n]; i < begin[n + 1]; ++i) {
        const std::uint32_t number = place[unions.find(i)];
        if (number == 0) continue;
        std::vector<PatchPixel>& patch = patches[number - 1];
        const float depth = depth_of(order[i]);
        if (patch.empty() || patch.back().pixel != pixels[n])
          patch.push_back({pixels[n], depth});
        else if (axes_.facing * depth > axes_.facing * patch.back().depth)
          patch.back().depth = depth;
      }
    }
    return patches;
  }

  struct Choice {
    std::size_t layer;
    float cost;
  };

  /// The layer that a patch costs least in; plan_ is then the patch in blocks.
  Choice cheapest(const std::vector<PatchPixel>& patch) {
    for (const std::size_t b : plan_) sums_of_patch_[b] = {};
    plan_.clear();
    for (const PatchPixel& pixel : patch) {
      const std::size_t b = sums_[0].of_pixel(pixel.pixel, pixels_);
      BlockSums::Block& block = sums_of_patch_[b];
      if (block.count == 0.0f) plan_.push_back(b);
      block.sum += pixel.depth;
      ++block.count;
    }
    Choice best{0, 1e30f};
    for (std::size_t l = 0; l < kViewLayers; ++l) {
      float cost = 0.02f * static_cast<float>(l) * static_cast<float>(plan_.size());
      for (const std::size_t b : plan_) cost += cost_of(b, l);
      if (cost < best.cost) best = {l, cost};
    }
    return best;
  }

  float cost_of(std::size_t b, std::size_t layer) const {
    const BlockSums& sums = sums_[layer];
    const float mean = sums_of_patch_[b].mean();
    const int bx = static_cast<int>(b) % sums.side, by = static_cast<int>(b) / sums.side;
    float cost = 0.0f;
    for (int y = std::max(0, by - 1); y <= std::min(sums.side - 1, by + 1); ++y) {
      for (int x = std::max(0, bx - 1); x <= std::min(sums.side - 1, bx + 1); ++x) {
        const bool same = x == bx && y == by;
        const BlockSums::Block& other = sums.blocks[static_cast<std::size_t>(y * sums.side + x)];
        if (other.count > 0.0f && std::abs(other.mean() - mean) > (same ? kSameBlock : kNearBlock))
          cost += same ? 3.0f : 0.25f;
      }
    }
    if (!before_.empty()) {
      const BlockSums::Block& old = before_[layer].blocks[b];
      if (old.count > 0.0f) cost += std::abs(old.mean() - mean) < kNearBlock ? -1.0f : 0.5f;
    }
    return cost;
  }

  void put(const std::vector<PatchPixel>& patch, std::size_t layer) {
    ViewLayer& into = layers_[layer];
    BlockSums& sums = sums_[layer];
    if (!into.used()) begin(into);
    // Blocks that hold something else keep it.
    for (const std::size_t b : plan_) {
      const BlockSums::Block& held = sums.blocks[b];
      if (held.count > 0.0f && std::abs(held.mean() - sums_of_patch_[b].mean()) > kSameBlock)
        sums_of_patch_[b].count = 0.0f;
    }
    for (const PatchPixel& pixel : patch) {
      if (sums_of_patch_[sums.of_pixel(pixel.pixel, pixels_)].count == 0.0f) continue;
      float& depth = into.depth[into.index(static_cast<int>(pixel.pixel % pixels_),
                                           static_cast<int>(pixel.pixel / pixels_))];
      if (depth != ViewLayer::kNone) continue;
      depth = pixel.depth;
      sums.add(pixel.pixel, pixels_, pixel.depth);
    }
  }

  /// Nothing of the frame lies outside of the points' bounds.
  void begin(ViewLayer& layer) const {
    layer.left = points_.least[axes_.u];
    layer.top = points_.least[axes_.v];
    layer.width = points_.most[axes_.u] - layer.left + 1;
    layer.height = points_.most[axes_.v] - layer.top + 1;
    layer.depth.assign(
        static_cast<std::size_t>(layer.width) * static_cast<std::size_t>(layer.height),
        ViewLayer::kNone);
  }

  const SurfacePoints& points_;
  const ViewAxes& axes_;
  std::array<ViewLayer, kViewLayers>& layers_;
  std::size_t pixels_;  ///< along a side
  std::vector<BlockSums> sums_, before_;
  std::vector<std::size_t> plan_;
  std::vector<BlockSums::Block> sums_of_patch_;
  std::vector<std::uint32_t> number_;
};

/// Whether a pixel of a view is within one pixel of a place along each axis.
bool is_near(const glm::vec3& place, const ViewAxes& axes,
             const std::array<ViewLayer, kViewLayers>& layers) {
  const glm::ivec3 cell(place);
  const int u = cell[axes.u], v = cell[axes.v];
  for (const ViewLayer& layer : layers) {
    if (!layer.used()) continue;
    const auto holds = [&](int x, int y) {
      const float depth = layer.at(x, y);
      return depth != ViewLayer::kNone && std::abs(depth - place[axes.depth]) <= 1.01f;
    };
    if (holds(u, v)) return true;
    for (int y = v - 1; y <= v + 1; ++y)
      for (int x = u - 1; x <= u + 1; ++x)
        if (holds(x, y)) return true;
  }
  return false;
}

/// Those of the points that have no pixel within one pixel along each axis.
std::vector<std::uint32_t> uncovered(const SurfacePoints& points,
                                     const std::vector<std::uint32_t>& of,
                                     const std::vector<std::uint8_t>& labels,
                                     const ViewLayers& layers, const Executor& executor) {
  return filter_points(of, executor, [&](std::uint32_t i) {
    const auto near = [&](std::size_t v) {
      return is_near(points.places[i], kViewAxes[v], layers[v]);
    };
    bool found = near(labels[i]);
    for (std::size_t v = 0; v < kViews && !found; ++v) found = v != labels[i] && near(v);
    return !found;
  });
}

/// The points of a view, in the order of their pixels and then of their depth.
std::vector<std::uint32_t> of_view(const SurfacePoints& points,
                                   const std::vector<std::uint8_t>& labels, int view) {
  const SurfacePoints::Columns& columns = points.columns[static_cast<std::size_t>(view / 2)];
  std::vector<std::uint32_t> chosen;
  std::copy_if(columns.points.begin(), columns.points.end(), std::back_inserter(chosen),
               [&](std::uint32_t i) { return labels[i] == view; });
  return chosen;
}

/// The same of a few points.
std::vector<std::uint32_t> of_view(const SurfacePoints& points,
                                   const std::vector<std::uint8_t>& labels, int view,
                                   const std::vector<std::uint32_t>& few) {
  const ViewAxes& axes = kViewAxes[static_cast<std::size_t>(view)];
  std::vector<std::uint32_t> chosen;
  std::copy_if(few.begin(), few.end(), std::back_inserter(chosen),
               [&](std::uint32_t i) { return labels[i] == view; });
  const auto key = [&](std::uint32_t i) {
    return std::make_tuple(points.pixel_of(i, axes), points.places[i][axes.depth], i);
  };
  std::sort(chosen.begin(), chosen.end(), [&](auto a, auto b) { return key(a) < key(b); });
  return chosen;
}

}  // namespace

ViewLayers lay_into_views(const SurfacePoints& points, const std::vector<std::uint8_t>& labels,
                          const ViewLayers* before, const Executor& executor) {
  ViewLayers layers;
  std::array<std::optional<OneView>, kViews> views;
  std::vector<std::uint32_t> left(points.size());
  std::iota(left.begin(), left.end(), 0u);
  for (int pass = 0; pass < kPasses; ++pass) {
    for_each(executor, kViews, [&](int view) {
      const auto v = static_cast<std::size_t>(view);
      if (pass == 0)
        views[v].emplace(points, view, before != nullptr ? &(*before)[v] : nullptr, layers[v]);
      views[v]->lay(pass == 0 ? of_view(points, labels, view) : of_view(points, labels, view, left),
                    pass > 0);
    });
    if (pass + 1 < kPasses) left = uncovered(points, left, labels, layers, executor);
  }
  return layers;
}

}  // namespace pointreel
