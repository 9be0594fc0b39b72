#include "codec/video_encode/color_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "codec/video/picture_points.h"
#include "codec/video_encode/decoded_points.h"
#include "common/base/for_each.h"

namespace pointreel {
namespace {

constexpr std::uint32_t kNobody = DecodedPoints::kNobody;
constexpr int kFar = 4;  ///< how far from a decoded point its colour may come, in pixels
/// A point looks for its nearest decoded one in the views that it faces by more than this.
constexpr float kFaces = 0.1f;

/// A decoded point that is nearer than this, as a square, is where the point is.
constexpr float kAtPoint = 0.25f;

/// The source's point nearest to a place; kNobody if none is near.
std::uint32_t nearest_source(const SurfacePoints& source, int view, const glm::vec3& place) {
  const ViewAxes& axes = kViewAxes[static_cast<std::size_t>(view)];
  const SurfacePoints::Columns& columns = source.columns[static_cast<std::size_t>(axes.depth)];
  const glm::ivec3 cell(place);
  std::uint32_t best = kNobody;
  // Points of other pixels are hardly nearer than one that is less than a pixel below.
  for (const int reach : {0, 1, kFar}) {
    float least = reach == 0 ? 1.0f : static_cast<float>(kFar * kFar) + 1.0f;
    for (int v = std::max(0, cell[axes.v] - reach);
         v <= std::min(source.side - 1, cell[axes.v] + reach); ++v) {
      for (int u = std::max(0, cell[axes.u] - reach);
           u <= std::min(source.side - 1, cell[axes.u] + reach); ++u) {
        const std::size_t pixel =
            static_cast<std::size_t>(v) * static_cast<std::size_t>(source.side) +
            static_cast<std::size_t>(u);
        for (std::size_t k = columns.first(pixel); k < columns.end(pixel); ++k) {
          const glm::vec3 away = source.places[columns.points[k]] - place;
          const float square = glm::dot(away, away);
          if (square >= least) continue;
          least = square;
          best = columns.points[k];
        }
      }
    }
    if (best != kNobody) break;
  }
  return best;
}

constexpr std::size_t kPointsInShare = 1u << 15;

template <class Body>
void for_each_point(const SurfacePoints& source, const Executor& executor, const Body& body) {
  for_each(executor, static_cast<int>((source.size() + kPointsInShare - 1) / kPointsInShare),
           [&](int share) {
             const std::size_t begin = static_cast<std::size_t>(share) * kPointsInShare,
                               end = std::min(source.size(), begin + kPointsInShare);
             for (std::size_t i = begin; i < end; ++i) body(i);
           });
}

/// The mean of the known ones of four pixels of each plane.
void halve(const std::vector<glm::vec3>& colors, ColorPlanes& planes) {
  for (int y = 0; y < planes.cb.height; ++y) {
    for (int x = 0; x < planes.cb.width; ++x) {
      glm::vec3 sum(0.0f);
      float count = 0.0f;
      for (int k = 0; k < 4; ++k) {
        const std::size_t p = planes.luma.at(2 * x + k % 2, 2 * y + k / 2);
        if (planes.luma.known[p] == 0) continue;
        sum += colors[p];
        ++count;
      }
      if (count == 0.0f) continue;
      const std::size_t p = planes.cb.at(x, y);
      planes.cb.values[p] = sum.y / count;
      planes.cr.values[p] = sum.z / count;
      planes.cb.known[p] = planes.cr.known[p] = 1;
    }
  }
}

}  // namespace

ColorPlanes color_planes(const VideoGroup& group, const DecodedDepth& decoded,
                         const SurfacePoints& source, const Executor& executor) {
  const DecodedPoints points(group, decoded);
  std::vector<std::uint32_t> target(source.size());
  for_each_point(source, executor, [&](std::size_t i) {
    const glm::vec3& normal = source.normals[i];
    const std::size_t best = faced_most(normal);
    DecodedPoints::Found found;
    points.look(best, source.places[i], 1, found);
    for (std::size_t v = 0; v < kViews && found.square > kAtPoint; ++v)
      if (v != best && faces(normal, v) > kFaces) points.look(v, source.places[i], 1, found);
    target[i] = found.square <= static_cast<float>(kFar * kFar) ? found.pixel : kNobody;
  });
  std::vector<glm::vec4> sums(group.pixels(), glm::vec4(0.0f));
  for (std::size_t i = 0; i < source.size(); ++i)
    if (target[i] != kNobody) sums[target[i]] += glm::vec4(source.color(i), 1.0f);

  ColorPlanes planes{Plane(group.width, group.height), Plane(group.width / 2, group.height / 2),
                     Plane(group.width / 2, group.height / 2)};
  std::vector<glm::vec3> colors(group.pixels());
  for_each(executor, static_cast<int>(group.patches.size()), [&](int i) {
    const Patch& patch = group.patches[static_cast<std::size_t>(i)];
    for (int y = 0; y < patch.height; ++y) {
      for (int x = 0; x < patch.width; ++x) {
        const std::size_t p = planes.luma.at(patch.atlas_x + x, patch.atlas_y + y);
        if (decoded.depth[p] == DecodedDepth::kNoPoint) continue;
        const std::uint32_t nearest =
            nearest_source(source, patch.view, place_of(patch, x, y, decoded.depth[p]));
        const bool any = sums[p].w > 0.0f;
        if (!any && nearest == kNobody) continue;
        const glm::vec3 mean = any ? glm::vec3(sums[p]) / sums[p].w : source.color(nearest);
        const glm::vec3 rgb =
            nearest == kNobody ? mean : 0.6f * mean + 0.4f * source.color(nearest);
        colors[p] = ycbcr_of(rgb);
        planes.luma.values[p] = colors[p].x;
        planes.luma.known[p] = 1;
      }
    }
  });
  halve(colors, planes);
  return planes;
}

}  // namespace pointreel
