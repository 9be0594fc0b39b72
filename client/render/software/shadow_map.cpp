#include "client/render/software/shadow_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "client/render/shading.h"
#include "common/base/for_each.h"

namespace pointreel {
namespace {

constexpr int kParts = 4;  ///< of the instances
constexpr int kRows = 16;  ///< of the map that are blurred at a time
constexpr std::array<float, 4> kBlur = {0.2f, 0.18f, 0.14f, 0.08f};  ///< binomial, nearly

std::size_t index(int x, int y) {
  return static_cast<std::size_t>(y) * kShadowEdge + static_cast<std::size_t>(x);
}

/// The weighted mean of a texel and its neighbours.
template <class At>
glm::vec2 blurred(int middle, const At& at) {
  glm::vec2 sum = kBlur[0] * at(middle);
  for (int i = 1; i < 4; ++i)
    sum += kBlur[static_cast<std::size_t>(i)] *
           (at(std::max(middle - i, 0)) + at(std::min(middle + i, kShadowEdge - 1)));
  return sum;
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
        return static_cast<int>(std::ceil(std::clamp(v - 0.5f, 0.0f, edge)));
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
  rows_.resize(kTexels);
  moments_.resize(kTexels);
  for_each(executor, kShadowEdge / kRows, [&](int block) {
    for (int y = block * kRows; y < (block + 1) * kRows; ++y) {
      std::array<glm::vec2, kShadowEdge> row;
      for (int x = 0; x < kShadowEdge; ++x) {
        float z = 0.0f;
        for (const auto& part : parts_) z = std::max(z, part[index(x, y)]);
        row[static_cast<std::size_t>(x)] = {z, z * z};
      }
      for (int x = 0; x < kShadowEdge; ++x)
        rows_[index(x, y)] = blurred(x, [&](int i) { return row[static_cast<std::size_t>(i)]; });
    }
  });
  for_each(executor, kShadowEdge / kRows, [&](int block) {
    for (int y = block * kRows; y < (block + 1) * kRows; ++y)
      for (int x = 0; x < kShadowEdge; ++x)
        moments_[index(x, y)] = blurred(y, [&](int i) { return rows_[index(x, i)]; });
  });
}

float ShadowMap::light_at(const glm::vec3& point, float apart) const {
  const float x = kShadowEdge * point.x - 0.5f, y = kShadowEdge * point.y - 0.5f;
  if (!(x >= 0.0f && y >= 0.0f && x < kShadowEdge - 1 && y < kShadowEdge - 1)) return 1.0f;
  const int left = static_cast<int>(x), below = static_cast<int>(y);
  const float right_share = x - static_cast<float>(left),
              above_share = y - static_cast<float>(below);
  const glm::vec2 *low = &moments_[index(left, below)], *high = low + kShadowEdge;
  const glm::vec2 mean = glm::mix(glm::mix(low[0], low[1], right_share),
                                  glm::mix(high[0], high[1], right_share), above_share);
  // Where nothing is, the map has 0.
  const float behind = mean.x - std::max(point.z, 0.0f) - apart;
  if (!(behind > 0.0f)) return 1.0f;
  const float variance = std::max(mean.y - mean.x * mean.x, 1e-6f);
  // The most that can be lit (Chebyshev). The last part of it is mostly light that leaks.
  const float most = variance / (variance + behind * behind);
  return std::clamp((most - kLeak) / (1.0f - kLeak), 0.0f, 1.0f);
}

}  // namespace pointreel
