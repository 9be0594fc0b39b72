#include "client/render/software/hole_filling.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

#include "client/render/hole_rules.h"
#include "common/base/for_each.h"

namespace pointreel {
namespace {

using namespace hole_rules;

constexpr int kRows = 16;  ///< of a level that one task computes

void for_rows(const Executor& executor, int rows, const std::function<void(int, int)>& body) {
  for_each(executor, (rows + kRows - 1) / kRows,
           [&](int i) { body(i * kRows, std::min((i + 1) * kRows, rows)); });
}

/// The share of a square that is covered, from which on a pixel in its middle is a hole: at the
/// outline of a surface no more than half of it is.
constexpr float kMostlyCovered = 0.7f;
/// The share that is covered of some square around a hole. A side that is open has no surface
/// around it that it could be a hole of.
constexpr float kLeastAround = 0.3f;

/// The seventh root of a number >= 1, the same on every machine: Newton's method from a guess by
/// the exponent. Wrong by less than 1e-6.
float seventh_root(float v) {
  constexpr std::int32_t kOne = std::bit_cast<std::int32_t>(1.0f);
  float root = std::bit_cast<float>((std::bit_cast<std::int32_t>(v) - kOne) / 7 + kOne);
  for (int i = 0; i < 3; ++i) {
    const float cube = root * root * root, sixth = cube * cube;
    root -= (sixth * root - v) / (7.0f * sixth);
  }
  return root;
}

}  // namespace

void HoleFilling::Level::resize(glm::ivec2 texels_in) {
  size = texels_in;
  texels.resize(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y));
}

glm::vec4 HoleFilling::Level::sample(const glm::vec2& place) const {
  const glm::vec2 at = glm::clamp(place - 0.5f, glm::vec2(0.0f), glm::vec2(size - 1));
  const glm::ivec2 low(at);
  const glm::ivec2 high = glm::min(low + 1, size - 1);
  const glm::vec2 f = at - glm::vec2(low);
  return glm::mix(glm::mix(this->at(low.x, low.y), this->at(high.x, low.y), f.x),
                  glm::mix(this->at(low.x, high.y), this->at(high.x, high.y), f.x), f.y);
}

void HoleFilling::clear_see_through(const PictureView& view, float radius, float nearest,
                                    const Executor& executor, Picture& picture) {
  // How far a hole reaches from one of its pixels to its rim at most, and how much nearer the rim
  // is at least, in radii; and in how many distances, for each direction, it is looked for
  // (see_through.frag.glsl).
  constexpr float kRim = 5.0f, kNearer = 4.0f;
  constexpr int kDistances = 8;  // seventh_root is for seven steps between them
  constexpr int kAround[8][2] = {{1, 0}, {-1, 0},  {0, 1},  {0, -1},
                                 {1, 1}, {-1, -1}, {-1, 1}, {1, -1}};
  const glm::ivec2 size = picture.grid.size;
  const float near = view.eye.w;
  const auto reach_at = [&](float w) { return std::max(kRim * radius / (view.pixel.x * w), 2.0f); };
  const float most_steps_at_nearest = reach_at(nearest);
  for_each(executor, picture.grid.count(), [&](int tile) {
    if (!picture.busy[static_cast<std::size_t>(tile)]) return;
    const PixelRect pixels = picture.grid.pixels(tile);
    for (int y = pixels.min.y; y < pixels.max.y; ++y) {
      for (int x = pixels.min.x; x < pixels.max.x; ++x) {
        const std::size_t at = picture.index(x, y);
        const float own = picture.depths[at];
        if (own == 0.0f || picture.colors[at].a != kDrawn) continue;
        // The depth that the rim has at most. The nearer it is, the larger its surfels look.
        const float most = near / own - kNearer * radius;
        if (most <= nearest) continue;
        // The distances grow from the least to the largest by a constant factor.
        const float least = std::max(0.25f * reach_at(most), 1.0f);
        const float most_steps = std::clamp(most_steps_at_nearest, least,
                                            std::max(least, 0.5f * static_cast<float>(size.y)));
        const float factor = seventh_root(most_steps / least);
        float lengths[kDistances] = {least};
        for (int k = 1; k < kDistances; ++k) lengths[k] = lengths[k - 1] * factor;
        bool surrounded = true;
        for (int i = 0; i < 8 && surrounded; ++i) {
          bool rim = false;
          for (int k = 0; k < kDistances && !rim; ++k) {
            const int step = static_cast<int>(lengths[k] + 0.5f);
            const int there_x = x + step * kAround[i][0], there_y = y + step * kAround[i][1];
            // The edge of the picture may cut a hole.
            if (there_x < 0 || there_y < 0 || there_x >= size.x || there_y >= size.y) {
              rim = true;
            } else {
              const float w =
                  near / std::max(picture.depths[picture.index(there_x, there_y)], 1e-30f);
              rim = w < most && lengths[k] <= reach_at(w);
            }
          }
          surrounded = rim;
        }
        if (surrounded) picture.colors[at].a = 0;
      }
    }
  });
}

void HoleFilling::find(const Picture& picture, float radius, const Executor& executor) {
  const glm::ivec2 size = picture.grid.size;
  std::size_t levels = 0;
  glm::ivec2 texels = (size + kFinest - 1) / kFinest;
  for (int edge = kFinest;; edge *= 2, texels = (texels + 1) / 2) {
    if (pulled_.size() <= levels) pulled_.emplace_back();
    pulled_[levels++].resize(texels);
    if (edge * kFarthest >= size.y || texels == glm::ivec2(1)) break;
  }
  pulled_.resize(levels);
  pushed_.resize(levels - 1);
  for (std::size_t i = 0; i + 1 < levels; ++i) pushed_[i].resize(pulled_[i].size);

  const SrgbTables& srgb = SrgbTables::get();
  Level& finest = pulled_[0];
  // Each texel takes the mean of four pixels of its square, no two of which are in the same row or
  // column.
  constexpr int kPlaces[4] = {1, 3, 0, 2};
  for_rows(executor, finest.size.y, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      for (int x = 0; x < finest.size.x; ++x) {
        glm::vec4 total(0.0f);
        const int tile =
            kFinest * y / kTileHeight * picture.grid.tiles.x + kFinest * x / kTileWidth;
        if (picture.busy[static_cast<std::size_t>(tile)]) {
          for (int i = 0; i < 4; ++i) {
            const int px = kFinest * x + kPlaces[i], py = kFinest * y + i;
            if (px >= size.x || py >= size.y) continue;
            const glm::u8vec4& color = picture.colors[picture.index(px, py)];
            if (color.a == kDrawn) total += glm::vec4(srgb.decode(color), 1.0f);
          }
        }
        finest.at(x, y) = 0.25f * total;
      }
    }
  });
  for (std::size_t i = 1; i < levels; ++i) {
    const Level& finer = pulled_[i - 1];
    Level& coarser = pulled_[i];
    for_rows(executor, coarser.size.y, [&](int begin, int end) {
      for (int y = begin; y < end; ++y) {
        for (int x = 0; x < coarser.size.x; ++x) {
          glm::vec4 total(0.0f);
          for (int k = 0; k < 4; ++k) {
            const int fx = 2 * x + (k & 1), fy = 2 * y + (k >> 1);
            if (fx < finer.size.x && fy < finer.size.y) total += finer.at(fx, fy);
          }
          coarser.at(x, y) = 0.25f * total;
        }
      }
    });
  }
  const Level* filled = &pulled_.back();
  for (std::size_t i = pushed_.size(); i-- > 0;) {
    const Level& own = pulled_[i];
    Level& to = pushed_[i];
    for_rows(executor, to.size.y, [&](int begin, int end) {
      for (int y = begin; y < end; ++y) {
        for (int x = 0; x < to.size.x; ++x) {
          const glm::vec4& mean = own.at(x, y);
          const glm::vec4 around = filled->sample(0.5f * (glm::vec2(x, y) + 0.5f));
          to.at(x, y) = mean.a > 0.0f ? std::max(1.0f, around.a / mean.a) * mean : around;
        }
      }
    });
    filled = &to;
  }
  crowd_ = 0;
  crowd_edge_ = kFinest;
  while (crowd_ + 1 < levels && static_cast<float>(2 * crowd_edge_) <= kGap * radius) {
    ++crowd_;
    crowd_edge_ *= 2;
  }
}

/// A pixel is a hole if it shows the inside of a surface, if all its neighbours show a surface, or
/// if most of the area around it is covered. Near the border of the picture, the area around a
/// pixel is not known.
bool HoleFilling::is_hole(const Picture& picture, int x, int y) const {
  const glm::ivec2 size = picture.grid.size;
  const glm::vec2 at = glm::vec2(x, y) + 0.5f;
  const float d = 0.5f * static_cast<float>(crowd_edge_);
  const auto seen = [&](float dx, float dy) {
    const glm::ivec2 there =
        glm::clamp(glm::ivec2(glm::floor(at + glm::vec2(dx, dy))), glm::ivec2(0), size - 1);
    return picture.depths[picture.index(there.x, there.y)] > 0.0f;
  };
  if (seen(0, 0)) return true;
  if (seen(d, d) && seen(d, -d) && seen(-d, d) && seen(-d, -d) && seen(d, 0) && seen(-d, 0) &&
      seen(0, d) && seen(0, -d))
    return true;
  const float edge = static_cast<float>(crowd_edge_);
  const glm::vec2 border = glm::min(at, glm::vec2(size) - at);
  if (std::min(border.x, border.y) < edge) return false;
  return pulled_[crowd_].sample(at / edge).a >= kMostlyCovered;
}

void HoleFilling::fill(const Executor& executor, Picture& picture) const {
  const Level& filled = pushed_.empty() ? pulled_[0] : pushed_[0];
  const Level& crowd = pulled_[crowd_];
  const SrgbTables& srgb = SrgbTables::get();
  const TileGrid& grid = picture.grid;
  // Alphas change while other tiles are filled, but nobody here looks at those of others.
  for_each(executor, grid.count(), [&](int tile) {
    const PixelRect pixels = grid.pixels(tile);
    if (!picture.busy[static_cast<std::size_t>(tile)]) {
      // Without any splat, this is all background unless it lies within a very large hole.
      const glm::ivec2 first = glm::max(pixels.min / crowd_edge_ - 1, 0),
                       last = glm::min(pixels.max / crowd_edge_ + 1, crowd.size - 1);
      bool crowded = false;
      for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) crowded = crowded || crowd.at(x, y).a > 0.0f;
      if (!crowded) return;
    }
    for (int y = pixels.min.y; y < pixels.max.y; ++y) {
      for (int x = pixels.min.x; x < pixels.max.x; ++x) {
        glm::u8vec4& color = picture.colors[picture.index(x, y)];
        if (color.a == kDrawn || !is_hole(picture, x, y)) continue;
        const glm::vec4 mean =
            filled.sample((glm::vec2(x, y) + 0.5f) / static_cast<float>(kFinest));
        if (mean.a >= kLeastAround) color = srgb.encode(glm::vec3(mean) / mean.a, kDrawn);
      }
    }
  });
}

}  // namespace pointreel
