#include "codec/surface/clean_in_time.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "codec/surface/mean_colors.h"
#include "codec/surface/point_surface.h"
#include "codec/surface/support.h"
#include "common/base/for_each.h"
#include "common/base/median.h"

namespace pointreel {
namespace {

/// The edge of the finest pieces of surface, in radii of support: pieces then hold some ten points.
constexpr double kPieceOfRadius = 0.4;
/// Surfaces of two frames are the same if they are no further apart than so many times the noise.
constexpr double kTolerance = 1.0;
/// Mean colours of the same place differ by at most so many standard deviations, and in addition by
/// 8 of 255 levels.
constexpr float kColorDeviations = 3.0f;
constexpr float kColorTolerance = 8.0f * 257.0f;
/// Noise that is alike at neighbouring points looks like shape within a frame, but not between
/// frames. Where this many frames count, or more, it is so many times what a frame shows.
constexpr float kFramesForHidden = 3.0f;
constexpr float kHidden = 1.4f;

/// Whether frames around it can help. Scans of less noise were not nearer to the truth.
bool is_noisy(const CleanReport& report) {
  return report.cleaned && steps_to_surface(report.noise, report.spacing) > 1;
}

std::vector<PieceColor> piece_colors(const CleanedFrame& frame) {
  const SurfacePieces& pieces = frame.pieces.levels.front();
  std::vector<PieceColor> colors(pieces.pieces.size());
  for (std::size_t i = 0; i < frame.before.colors.size(); ++i) {
    PieceColor& piece = colors[pieces.of_point[i]];
    const glm::vec3 color(frame.before.colors[i]);
    piece.mean += color;
    piece.variance += glm::dot(color, color);
    piece.points += 1.0f;
  }
  for (PieceColor& piece : colors) {
    if (piece.points == 0.0f) continue;
    piece.mean /= piece.points;
    piece.variance =
        std::max(piece.variance / piece.points - glm::dot(piece.mean, piece.mean), 0.0f);
  }
  return colors;
}

/// Whether two pieces may have the same colours, as far as so few points tell.
bool agree(const PieceColor& a, const PieceColor& b) {
  const glm::vec3 difference = a.mean - b.mean;
  const float noise = a.variance / a.points + b.variance / b.points;
  return glm::dot(difference, difference) <=
         kColorDeviations * kColorDeviations * noise + kColorTolerance * kColorTolerance;
}

/// What another frame contributes: its points as they would be in the frame that is cleaned.
struct Carried {
  PointCloud points;                 ///< where they were measured, with normals
  std::vector<glm::vec3> positions;  ///< where cleaning alone has put them
};

/// Colours that change with time, or slide along the surface, are replaced by the frame's own.
/// `carried_from`: those of the piece that each point comes from.
void keep_own_colors(const CleanedFrame& frame, const std::vector<const PieceColor*>& carried_from,
                     Carried& carried) {
  constexpr float kAnywhere = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < carried_from.size(); ++i) {
    const auto piece = nearest_piece(frame.pieces.levels.front(), carried.positions[i],
                                     carried.points.normals[i], 0.0f, kAnywhere);
    if (piece && !agree(frame.colors[*piece], *carried_from[i]))
      carried.points.colors[i] = glm::u16vec3(frame.colors[*piece].mean + 0.5f);
  }
}

Carried carry(const CleanedFrame& other, const CleanedFrame& frame) {
  const auto motions = surface_motion(other.pieces, other.cloud.positions, frame.pieces,
                                      static_cast<float>(kTolerance * frame.report.noise));
  const SurfacePieces& pieces = other.pieces.levels.front();
  std::vector<const PieceColor*> carried_from;
  Carried carried;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (!motions[i]) continue;
    carried.positions.push_back((*motions[i])(other.cloud.positions[i]));
    carried.points.positions.push_back((*motions[i])(other.before.positions[i]));
    carried.points.normals.push_back(motions[i]->rotation * other.cloud.normals[i]);
    if (!other.cloud.has_colors()) continue;
    carried.points.colors.push_back(other.before.colors[i]);
    carried_from.push_back(&other.colors[pieces.of_point[i]]);
  }
  keep_own_colors(frame, carried_from, carried);
  return carried;
}

std::vector<Carried> carry(std::span<const CleanedFrame* const> others, const CleanedFrame& frame,
                           const Executor& executor) {
  std::vector<Carried> carried(others.size());
  for_each(executor, static_cast<int>(others.size()), [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    carried[at] = carry(*others[at], frame);
  });
  return carried;
}

void append(PointCloud& to, const PointCloud& more) {
  to.positions.insert(to.positions.end(), more.positions.begin(), more.positions.end());
  to.normals.insert(to.normals.end(), more.normals.begin(), more.normals.end());
  to.colors.insert(to.colors.end(), more.colors.begin(), more.colors.end());
}

/// The points of the frame where cleaning alone has put them, without normals: these are to move,
/// and have no say. Then all points where they were measured.
PointCloud all_points(const CleanedFrame& frame, std::span<const Carried> carried) {
  PointCloud all;
  all.origin = frame.cloud.origin;
  all.positions = frame.cloud.positions;
  all.normals.assign(all.size(), glm::vec3(0.0f));
  all.colors = frame.before.colors;
  append(all, {{}, frame.before.positions, frame.cloud.normals, frame.before.colors, {}, {}});
  for (const Carried& more : carried) append(all, more.points);
  return all;
}

/// How many times denser all points are around each point of the frame than its own.
std::vector<float> densities(const CleanedFrame& frame, std::span<const Carried> carried) {
  struct Count {
    float own = 0.0f, all = 0.0f;
  };
  std::unordered_map<GridCell, Count, GridCell::Hash> counts;
  const float edge = frame.pieces.levels.at(1).cell;
  for (const glm::vec3& position : frame.cloud.positions)
    counts[GridCell::at(position / edge)].own += 1.0f;
  for (const Carried& more : carried) {
    for (const glm::vec3& position : more.positions) {
      const auto found = counts.find(GridCell::at(position / edge));
      if (found != counts.end()) found->second.all += 1.0f;
    }
  }
  std::vector<float> denser;
  for (const glm::vec3& position : frame.cloud.positions) {
    const Count& count = counts[GridCell::at(position / edge)];
    denser.push_back(
        std::min(1.0f + count.all / count.own, static_cast<float>(1 + carried.size())));
  }
  return denser;
}

/// What would be measured around each point of the frame among all points.
std::vector<Measured> measured_among_all(const CleanedFrame& frame,
                                         std::span<const Carried> carried) {
  std::vector<Measured> measured = frame.before.measured;
  const std::vector<float> denser = densities(frame, carried);
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const float share = std::min((denser[i] - 1.0f) / (kFramesForHidden - 1.0f), 1.0f);
    measured[i].noise *= 1.0f + (kHidden - 1.0f) * share;
    measured[i].spacing /= std::sqrt(denser[i]);
  }
  return measured;
}

/// From the order of the frame's points to that of the surface. Others have the value `other`.
template <class T>
std::vector<T> in_order(const std::vector<T>& of_points, const PointSurface& surface,
                        const T& other) {
  std::vector<T> out(surface.order().size(), other);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::uint32_t index = surface.order()[i].index;
    if (index < of_points.size()) out[i] = of_points[index];
  }
  return out;
}

}  // namespace

CleanedFrame clean_alone(PointCloud cloud, const CleanOptions& options, const Executor& executor) {
  CleanedFrame frame;
  frame.had_normals = cloud.has_normals();
  frame.cloud = std::move(cloud);
  frame.report = clean(frame.cloud, options, executor, &frame.before);
  if (!is_noisy(frame.report)) return frame;
  frame.pieces =
      surface_pyramid(frame.cloud, static_cast<float>(kPieceOfRadius * frame.report.radius));
  if (frame.cloud.has_colors()) frame.colors = piece_colors(frame);
  return frame;
}

std::optional<CleanedInTime> clean_in_time(const CleanedFrame& frame,
                                           std::span<const CleanedFrame* const> around,
                                           const CleanOptions& options, const Executor& executor) {
  if (!is_noisy(frame.report)) return std::nullopt;
  std::vector<const CleanedFrame*> others;
  for (const CleanedFrame* other : around)
    if (is_noisy(other->report) && other->cloud.has_colors() == frame.cloud.has_colors() &&
        other->before.positions != frame.before.positions)
      others.push_back(other);
  if (others.empty()) return std::nullopt;

  const std::vector<Carried> carried = carry(others, frame, executor);
  PointCloud all = all_points(frame, carried);
  const std::vector<Measured> own = measured_among_all(frame, carried);
  const std::vector<float> own_radii =
      options.radius ? std::vector<float>(own.size(), static_cast<float>(*options.radius))
                     : support(own);
  CleanedInTime out{frame.cloud, frame.report};
  out.report.radius = median(own_radii);

  const PointSurface surface(all, executor);
  const std::vector<float> radii = in_order(own_radii, surface, 0.0f);
  const std::vector<glm::vec3> normals = in_order(frame.cloud.normals, surface, glm::vec3(0.0f));
  const std::vector<SurfaceSample> samples =
      surface.project(radii, options.beta, 1, executor, normals);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!(samples[i].weight > 0.0f)) continue;
    const std::uint32_t index = surface.order()[i].index;
    out.cloud.positions[index] = samples[i].position;
    out.cloud.normals[index] = samples[i].normal;
  }
  if (all.has_colors()) {
    mean_colors(all, surface, in_order(own, surface, Measured{}), radii, executor, normals);
    std::copy_n(all.colors.begin(), own.size(), out.cloud.colors.begin());
  }
  return out;
}

}  // namespace pointreel
