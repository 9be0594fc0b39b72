#include "codec/video_encode/view_labels.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace pointreel {
namespace {

constexpr int kCell = 8;  ///< pixels along each side
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
  const auto cells_along = static_cast<std::uint32_t>(points.side / kCell + 1);
  const auto key_of = [&](const glm::ivec3& c) {
    return (static_cast<std::uint32_t>(c.z) * cells_along + static_cast<std::uint32_t>(c.y)) *
               cells_along +
           static_cast<std::uint32_t>(c.x);
  };
  // The cells that have points, numbered as they come.
  std::unordered_map<std::uint32_t, std::uint32_t> number;
  std::vector<glm::ivec3> places;
  std::vector<std::uint32_t> cell_of(points.size());
  std::vector<Cell> cells;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const glm::ivec3 place = glm::ivec3(points.places[i]) / kCell;
    const auto [found, fresh] =
        number.try_emplace(key_of(place), static_cast<std::uint32_t>(cells.size()));
    if (fresh) {
      cells.emplace_back();
      places.push_back(place);
    }
    cell_of[i] = found->second;
    Cell& cell = cells[found->second];
    cell.mean += points.places[i];
    ++cell.count;
  }
  std::vector<std::array<std::uint32_t, 27>> around(cells.size());
  std::vector<int> neighbors(cells.size(), 0);
  std::vector<Scores> kept(cells.size(), Scores{});
  for (std::size_t c = 0; c < cells.size(); ++c) {
    cells[c].mean /= cells[c].count;
    for (int n = 0; n < 27; ++n) {
      const glm::ivec3 place = places[c] + glm::ivec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      if (glm::any(glm::lessThan(place, glm::ivec3(0))) ||
          glm::any(glm::greaterThanEqual(place, glm::ivec3(static_cast<int>(cells_along)))))
        continue;
      if (const auto found = number.find(key_of(place)); found != number.end())
        around[c][static_cast<std::size_t>(neighbors[c]++)] = found->second;
    }
    const auto before = before_.find(key_of(places[c]));
    if (before == before_.end()) continue;
    float total = 0.0f;
    for (const float count : before->second.labels) total += count;
    const float weight =
        kBefore * stillness(before->second.mean, cells[c].mean) / std::max(total, 1.0f);
    for (std::size_t v = 0; v < kViews; ++v) kept[c][v] = weight * before->second.labels[v];
  }

  std::vector<std::uint8_t> labels(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) labels[i] = best(facing(points.normals[i]));
  std::vector<Scores> own(cells.size()), bias(cells.size());
  for (int round = 0; round < kMostRounds; ++round) {
    std::fill(own.begin(), own.end(), Scores{});
    for (std::size_t i = 0; i < points.size(); ++i) ++own[cell_of[i]][labels[i]];
    for (std::size_t c = 0; c < cells.size(); ++c) {
      Scores sum{};
      float total = 0.0f;
      for (int n = 0; n < neighbors[c]; ++n) {
        const Scores& other = own[around[c][static_cast<std::size_t>(n)]];
        for (std::size_t v = 0; v < kViews; ++v) sum[v] += other[v], total += other[v];
      }
      cells[c].labels = sum;
      for (std::size_t v = 0; v < kViews; ++v)
        bias[c][v] = kNeighbors * sum[v] / total + kept[c][v];
    }
    std::size_t changed = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      Scores scores = facing(points.normals[i]);
      for (std::size_t v = 0; v < kViews; ++v) scores[v] += bias[cell_of[i]][v];
      const std::uint8_t label = best(scores);
      changed += label != labels[i] ? 1 : 0;
      labels[i] = label;
    }
    if (changed < points.size() / 2000) break;
  }
  before_.clear();
  for (std::size_t c = 0; c < cells.size(); ++c) before_.emplace(key_of(places[c]), cells[c]);
  return labels;
}

}  // namespace pointreel
