#include "client/render/software/shadow_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "client/render/shading.h"
#include "client/render/software/bounded.h"
#include "common/base/for_each.h"

namespace pointreel {
namespace {

constexpr int kParts = 4;      ///< of the instances
constexpr int kBlurRows = 16;  ///< of the map that are blurred at a time
constexpr int kBlurred = 3;    ///< texels on each side of one
constexpr std::array<float, kBlurred + 1> kBlur = {0.2f, 0.18f, 0.14f,
                                                   0.08f};  ///< binomial, nearly

std::size_t index(int x, int y) {
  return static_cast<std::size_t>(y) * kShadowEdge + static_cast<std::size_t>(x);
}

/// Means of a texel and three on each side, for `count` numbers that begin at `from` and are
/// `apart` from their neighbours.
void blur(const float* from, std::ptrdiff_t apart, int count, float* to) {
  for (int i = 0; i < count; ++i) {
    const float* middle = from + i;
    to[i] = kBlur[0] * middle[0] + kBlur[1] * (middle[-apart] + middle[apart]) +
            kBlur[2] * (middle[-2 * apart] + middle[2 * apart]) +
            kBlur[3] * (middle[-3 * apart] + middle[3 * apart]);
  }
}

}  // namespace

void ShadowMap::draw(std::span<const Instance> instances, const glm::mat4& to_shadow,
                     const Executor& executor) {
  constexpr std::size_t kTexels = static_cast<std::size_t>(kShadowEdge) * kShadowEdge;
  parts_.resize(kParts);
  const float edge = kShadowEdge;
  const float scale =
      edge * glm::length(glm::vec3(to_shadow[0][0], to_shadow[1][0], to_shadow[2][0]));
  for_each(executor, kParts, [&](int part) {
    std::vector<float>& nearest = parts_[static_cast<std::size_t>(part)];
    nearest.assign(kTexels, 0.0f);
    const std::size_t begin = instances.size() * static_cast<std::size_t>(part) / kParts,
                      end = instances.size() * static_cast<std::size_t>(part + 1) / kParts;
    for (const Instance& one : instances.subspan(begin, end - begin)) {
      const glm::vec3 at = glm::vec3(to_shadow * glm::vec4(one.center, 1.0f));
      // As OpenGL draws points: squares of at least one texel.
      const float half = std::max(0.5f, scale * one.radius);
      const auto first = [edge](float v) {
        return static_cast<int>(std::ceil(bounded(v - 0.5f, 0.0f, edge)));
      };
      const int x0 = first(edge * at.x - half), x1 = first(edge * at.x + half),
                y0 = first(edge * at.y - half), y1 = first(edge * at.y + half);
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
          float& texel = nearest[index(x, y)];
          texel = std::max(texel, at.z);
        }
    }
  });
  // Beyond the edge, all is as at the edge.
  constexpr int kRowLength = 2 * kShadowEdge;
  rows_.resize(static_cast<std::size_t>(kRowLength) * (kShadowEdge + 2 * kBlurred));
  moments_.resize(2 * kTexels);
  const auto row_at = [this](int y) {
    return rows_.begin() + static_cast<std::ptrdiff_t>(kRowLength) * (y + kBlurred);
  };
  for_each(executor, kShadowEdge / kBlurRows, [&](int block) {
    for (int y = block * kBlurRows; y < (block + 1) * kBlurRows; ++y) {
      std::array<float, kRowLength + 4 * kBlurred> row;
      for (int x = -kBlurred; x < kShadowEdge + kBlurred; ++x) {
        float z = 0.0f;
        for (const auto& part : parts_)
          z = std::max(z, part[index(std::clamp(x, 0, kShadowEdge - 1), y)]);
        const std::size_t at = 2 * static_cast<std::size_t>(x + kBlurred);
        row[at] = z;
        row[at + 1] = z * z;
      }
      blur(&row[2 * kBlurred], 2, kRowLength, &*row_at(y));
    }
  });
  for (int i = 1; i <= kBlurred; ++i) {
    std::copy_n(row_at(0), kRowLength, row_at(-i));
    std::copy_n(row_at(kShadowEdge - 1), kRowLength, row_at(kShadowEdge - 1 + i));
  }
  for_each(executor, kShadowEdge / kBlurRows, [&](int block) {
    for (int y = block * kBlurRows; y < (block + 1) * kBlurRows; ++y)
      blur(&*row_at(y), kRowLength, kRowLength, &moments_[2 * index(0, y)]);
  });
}

}  // namespace pointreel
