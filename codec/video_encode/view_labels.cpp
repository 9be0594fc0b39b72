#include "codec/video_encode/view_labels.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace pointreel {
namespace {

/// What the neighbours and the frame before count for, where a view that is faced squarely is 1.
constexpr float kNeighbors = 1.5f, kBefore = 1.0f;
constexpr int kMostRounds = 8;

using Scores = std::array<float, kViews>;

Scores facing(const glm::vec3& normal) {
  return {normal.x, -normal.x, normal.y, -normal.y, normal.z, -normal.z};
}

std::uint8_t best(const Scores& scores) {
  return static_cast<std::uint8_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
}

/// How little the surface has moved that passes through a cell: 1 if not at all, 0 from a pixel on.
float stillness(const glm::vec3& before, const glm::vec3& now) {
  return std::max(0.0f, 1.0f - glm::length(now - before));
}

}  // namespace

std::vector<std::uint8_t> ViewLabels::next(const SurfacePoints& points) {
  const auto cells_along = static_cast<std::uint32_t>(points.side / SurfacePoints::kCell + 1);
  const auto key_of = [&](const glm::ivec3& c) {
    return (static_cast<std::uint32_t>(c.z) * cells_along + static_cast<std::uint32_t>(c.y)) *
               cells_along +
           static_cast<std::uint32_t>(c.x);
  };
  const std::size_t count = points.cell_begin.size() - 1;
  std::unordered_map<std::uint32_t, std::uint32_t> number;
  std::vector<glm::ivec3> places(count);
  std::vector<Cell> cells(count);
  for (std::size_t c = 0; c < count; ++c) {
    places[c] = glm::ivec3(points.places[points.cell_begin[c]]) / SurfacePoints::kCell;
    number.emplace(key_of(places[c]), static_cast<std::uint32_t>(c));
    for (std::uint32_t i = points.cell_begin[c]; i < points.cell_begin[c + 1]; ++i)
      cells[c].mean += points.places[i];
    cells[c].mean /= static_cast<float>(points.cell_begin[c + 1] - points.cell_begin[c]);
  }
  std::vector<std::array<std::uint32_t, 27>> around(count);
  std::vector<std::size_t> neighbors(count, 0);
  std::vector<Scores> kept(count, Scores{});
  for (std::size_t c = 0; c < count; ++c) {
    for (int n = 0; n < 27; ++n) {
      const glm::ivec3 place = places[c] + glm::ivec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      if (glm::any(glm::lessThan(place, glm::ivec3(0))) ||
          glm::any(glm::greaterThanEqual(place, glm::ivec3(static_cast<int>(cells_along)))))
        continue;
      if (const auto found = number.find(key_of(place)); found != number.end())
        around[c][neighbors[c]++] = found->second;
    }
    const auto before = before_.find(key_of(places[c]));
    if (before == before_.end()) continue;
    float total = 0.0f;
    for (const float labels : before->second.labels) total += labels;
    const float weight =
        kBefore * stillness(before->second.mean, cells[c].mean) / std::max(total, 1.0f);
    for (std::size_t v = 0; v < kViews; ++v) kept[c][v] = weight * before->second.labels[v];
  }

  std::vector<std::uint8_t> labels(points.size());
  std::vector<Scores> own(count, Scores{});
  for (std::size_t c = 0; c < count; ++c) {
    for (std::uint32_t i = points.cell_begin[c]; i < points.cell_begin[c + 1]; ++i) {
      labels[i] = best(facing(points.normals[i]));
      ++own[c][labels[i]];
    }
  }
  // A cell is looked at again where labels around it have changed.
  std::vector<std::uint8_t> open(count, 1), next(count);
  std::vector<std::pair<std::uint32_t, Scores>> changed;
  for (int round = 0; round < kMostRounds; ++round) {
    std::size_t points_changed = 0;
    changed.clear();
    for (std::size_t c = 0; c < count; ++c) {
      if (open[c] == 0) continue;
      Scores sum{};
      float total = 0.0f;
      for (std::size_t n = 0; n < neighbors[c]; ++n) {
        const Scores& other = own[around[c][n]];
        for (std::size_t v = 0; v < kViews; ++v) sum[v] += other[v], total += other[v];
      }
      cells[c].labels = sum;
      Scores bias, now{};
      for (std::size_t v = 0; v < kViews; ++v) bias[v] = kNeighbors * sum[v] / total + kept[c][v];
      const std::size_t before = points_changed;
      for (std::uint32_t i = points.cell_begin[c]; i < points.cell_begin[c + 1]; ++i) {
        Scores scores = facing(points.normals[i]);
        for (std::size_t v = 0; v < kViews; ++v) scores[v] += bias[v];
        const std::uint8_t label = best(scores);
        points_changed += label != labels[i] ? 1 : 0;
        labels[i] = label;
        ++now[label];
      }
      if (points_changed > before) changed.emplace_back(static_cast<std::uint32_t>(c), now);
    }
    if (points_changed < points.size() / 2000) break;
    std::fill(next.begin(), next.end(), std::uint8_t{0});
    for (const auto& [c, now] : changed) {
      own[c] = now;
      for (std::size_t n = 0; n < neighbors[c]; ++n) next[around[c][n]] = 1;
    }
    open.swap(next);
  }
  before_.clear();
  for (std::size_t c = 0; c < count; ++c) before_.emplace(key_of(places[c]), cells[c]);
  return labels;
}

}  // namespace pointreel
