#include "codec/surface/support.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "codec/surface/clean.h"
#include "common/base/median.h"

namespace pointreel {
namespace {

/// Noise is the same thing whatever surface the points are moved to.
constexpr double kMeasuredBeta = CleanOptions{}.beta;
constexpr std::size_t kAveraged = 60;
constexpr std::uint32_t kMeasuredOneIn = 16;
/// Spacing is between these shares of what counting the points nearby tells, which is not exact:
/// noise and other sheets of the surface make the count larger, up to 2.4 in scans.
constexpr float kLeastLocalSpacing = 0.8f;
constexpr float kMostLocalSpacing = 2.5f;
constexpr int kMeasurements = 4;
/// Scans often consist of curves with gaps between them. Where the points around a place extend
/// less than this in some direction, compared with the radius, the radius grows: along a single
/// curve, the surface could turn around it freely.
constexpr float kLeastExtent = 0.035f;
constexpr float kMostWidening = 3.0f;
/// The radius of support is at least so many spacings, and at least so many times the root of
/// spacing times noise.
constexpr float kLeastSpacings = 3.0f;
constexpr float kNoiseFactor = 8.0f;
/// The cells of a frame are at most so many times those that its densest parts need, and the
/// densest parts are this share of the points. Scans of one object have factors up to 1.6.
constexpr double kMostCoarsening = 2.0;
constexpr double kDensest = 0.01;

/// Above so many spacings of noise, points lie so far from the surface that it takes a second step
/// to look for it where it is.
constexpr double kNoisy = 0.25;

constexpr float kPi = 3.14159265f;

float support(const Measured& at) {
  return at.widening *
         std::max(kLeastSpacings * at.spacing, kNoiseFactor * std::sqrt(at.noise * at.spacing));
}

/// Finer cells would tell samples of the same spot apart: points are `spacing` apart, and details
/// much smaller than the support are gone.
float cell(const Measured& at) {
  return std::max(0.5f * at.spacing, std::sqrt(at.noise * at.spacing));
}

}  // namespace

std::vector<float> support(const std::vector<Measured>& measured) {
  std::vector<float> radii(measured.size());
  std::ranges::transform(measured, radii.begin(), [](const Measured& at) { return support(at); });
  return radii;
}

double cell(const std::vector<Measured>& measured) {
  std::vector<float> cells(measured.size());
  std::ranges::transform(measured, cells.begin(), [](const Measured& at) { return cell(at); });
  const double middle = median(cells);
  const auto densest =
      cells.begin() + static_cast<std::ptrdiff_t>(kDensest * static_cast<double>(cells.size()));
  std::nth_element(cells.begin(), densest, cells.end());
  return std::min(middle, kMostCoarsening * *densest);
}

float median_of(const std::vector<Measured>& measured, float Measured::* member) {
  std::vector<float> values(measured.size());
  std::ranges::transform(measured, values.begin(), std::mem_fn(member));
  return median(values);
}

int steps_to_surface(double noise, double spacing) { return noise > kNoisy * spacing ? 2 : 1; }

float weight_of_plane(float radius, float spacing) {
  const float ratio = radius / spacing;
  return kPi / 5.0f * ratio * ratio;
}

/// Noise is the distance to a surface that is fitted within a radius, which in turn depends on the
/// noise. A few rounds are enough, and so is a part of the points.
std::vector<Measured> measure(const PointSurface& surface, const Executor& executor) {
  std::vector<Measured> measured(surface.order().size());
  const std::vector<float> counted = surface.radii_of(kSupport);
  std::vector<float> radii = counted;
  for (int round = 0; round < kMeasurements; ++round) {
    const std::vector<SurfaceEvidence> evidence =
        surface.measure(radii, kMeasuredBeta, kMeasuredOneIn, executor);
    std::vector<glm::vec3> values(evidence.size());
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const auto& [square, weight, extent, neighbor_square] = evidence[i];
      const float spacing = radii[i] * std::sqrt(kPi / (5.0f * weight));
      const float wider = std::sqrt(kLeastExtent / std::max(extent, kLeastExtent / 4.0f));
      const float widening =
          std::clamp(measured[i].widening * std::max(wider, 1.0f), 1.0f, kMostWidening);
      values[i] = weight > 0.0f
                      ? glm::vec3(square, round == 0 ? spacing : neighbor_square, widening)
                      : glm::vec3(-1.0f);
    }
    const std::vector<glm::vec3> means = surface.local_means(values, kAveraged);
    for (std::size_t i = 0; i < means.size(); ++i) {
      measured[i].noise = std::sqrt(means[i].x);
      if (round == 0) {
        // Means reach from small objects to those nearby.
        const float local = counted[i] * std::sqrt(kPi / static_cast<float>(kSupport));
        measured[i].spacing =
            std::clamp(means[i].y, kLeastLocalSpacing * local, kMostLocalSpacing * local);
      } else {
        measured[i].difference = std::sqrt(means[i].y);
        measured[i].widening = std::max(means[i].z, 1.0f);
      }
    }
    radii = support(measured);
  }
  return measured;
}

}  // namespace pointreel
