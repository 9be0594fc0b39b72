#include "codec/video_encode/decoded_points.h"

#include <algorithm>

namespace pointreel {

DecodedDepth decoded_depth(const VideoGroup& group, const PixelDepths& depths) {
  DecodedDepth decoded;
  decoded.depth.assign(group.pixels(), DecodedDepth::kNoPoint);
  for (const Patch& patch : group.patches) {
    const DepthSteps& steps = group.depth[static_cast<std::size_t>(patch.view)];
    const float pixels = 1.0f / steps.steps;
    for (int y = patch.atlas_y; y < patch.atlas_y + patch.height; ++y) {
      const std::size_t row = group.pixel(patch.atlas_x, y);
      for (std::size_t p = row; p < row + static_cast<std::size_t>(patch.width); ++p) {
        const std::int16_t value = depths.values[p];
        if (value != PixelDepths::kNoPoint)
          decoded.depth[p] = steps.begin + pixels * static_cast<float>(value);
      }
    }
  }
  return decoded;
}

std::size_t faced_most(const glm::vec3& normal) {
  std::size_t best = 0;
  for (std::size_t v = 1; v < kViews; ++v)
    if (faces(normal, v) > faces(normal, best)) best = v;
  return best;
}

DecodedPoints::DecodedPoints(const VideoGroup& group, const DecodedDepth& decoded)
    : group_(group), decoded_(decoded) {
  for (const Patch& patch : group.patches)
    patches_[static_cast<std::size_t>(patch.view)].push_back(&patch);
}

bool DecodedPoints::has_near(std::size_t view, const glm::vec3& place, int reach) const {
  const ViewAxes& axes = kViewAxes[view];
  const glm::ivec3 cell(place);
  const auto most = static_cast<float>(reach * reach);
  for (const Patch* patch : patches_[view]) {
    const int x = cell[axes.u] - patch->x, y = cell[axes.v] - patch->y;
    if (x + reach < 0 || y + reach < 0 || x - reach >= patch->width || y - reach >= patch->height)
      continue;
    const auto is_near = [&](int u, int v) {
      const float down = static_cast<float>(patch->y + v) + 0.5f - place[axes.v];
      const float along = static_cast<float>(patch->x + u) + 0.5f - place[axes.u];
      const float deep =
          decoded_.depth[group_.pixel(patch->atlas_x + u, patch->atlas_y + v)] - place[axes.depth];
      return along * along + down * down + deep * deep <= most;
    };
    // Most points are right below a pixel.
    if (x >= 0 && y >= 0 && x < patch->width && y < patch->height && is_near(x, y)) return true;
    for (int v = std::max(0, y - reach); v <= std::min(patch->height - 1, y + reach); ++v)
      for (int u = std::max(0, x - reach); u <= std::min(patch->width - 1, x + reach); ++u)
        if (is_near(u, v)) return true;
  }
  return false;
}

void DecodedPoints::look(std::size_t view, const glm::vec3& place, int reach, Found& found) const {
  const ViewAxes& axes = kViewAxes[view];
  const glm::ivec3 cell(place);
  for (const Patch* patch : patches_[view]) {
    const int x = cell[axes.u] - patch->x, y = cell[axes.v] - patch->y;
    if (x + reach < 0 || y + reach < 0 || x - reach >= patch->width || y - reach >= patch->height)
      continue;
    for (int v = std::max(0, y - reach); v <= std::min(patch->height - 1, y + reach); ++v) {
      const float down = static_cast<float>(patch->y + v) + 0.5f - place[axes.v];
      const std::size_t row =
          static_cast<std::size_t>(patch->atlas_y + v) * static_cast<std::size_t>(group_.width);
      for (int u = std::max(0, x - reach); u <= std::min(patch->width - 1, x + reach); ++u) {
        const std::size_t pixel = row + static_cast<std::size_t>(patch->atlas_x + u);
        const float along = static_cast<float>(patch->x + u) + 0.5f - place[axes.u];
        const float deep = decoded_.depth[pixel] - place[axes.depth];
        const float square = along * along + down * down + deep * deep;
        if (square < found.square) found = {static_cast<std::uint32_t>(pixel), square};
      }
    }
  }
}

}  // namespace pointreel
