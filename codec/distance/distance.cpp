#include "codec/distance/distance.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include "codec/distance/nearest.h"

namespace pointreel {
namespace {

using Vectors = std::vector<glm::dvec3>;

/// The value that is not exceeded by `share` of the values, by nearest rank. Reorders `values`,
/// which must not be empty.
double percentile(std::vector<double>& values, double share) {
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  const auto nth =
      values.begin() + std::max(std::ptrdiff_t{0}, static_cast<std::ptrdiff_t>(rank) - 1);
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

/// The unit vector along v, or zero if v has no direction.
glm::dvec3 direction(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 1e-6 ? v / length : glm::dvec3(0.0);
}

bool is_known(const glm::dvec3& normal) { return normal != glm::dvec3(0.0); }

/// Y', Cb and Cr without their offsets, in 8-bit steps.
glm::dvec3 to_ycbcr(const glm::dvec3& color) {
  const glm::dvec3 c = color / 257.0;
  const double y = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
  return {y, (c.b - y) / 1.8556, (c.r - y) / 1.5748};
}

/// One of the two clouds.
struct Side {
  const PointCloud& cloud;
  DistinctPoints distinct;
  Vectors colors;   ///< mean Y', Cb, Cr of each distinct position
  Vectors normals;  ///< mean direction of each distinct position, or zero

  Side(const PointCloud& source, const Cube& cube)
      : cloud(source), distinct(distinct_points(source, cube)) {
    if (cloud.has_colors()) {
      colors = means([this](std::uint32_t i) { return to_ycbcr(glm::dvec3(cloud.colors[i])); });
    }
    if (cloud.has_normals()) {
      normals = means([this](std::uint32_t i) { return glm::dvec3(cloud.normals[i]); });
      for (glm::dvec3& normal : normals) normal = direction(normal);
    }
  }

  std::size_t size() const { return distinct.size(); }

 private:
  template <class Value>
  Vectors means(const Value& value) const {
    Vectors result(size());
    for (std::size_t i = 0; i < size(); ++i) {
      const auto members = distinct.at(i);
      for (const std::uint32_t member : members) result[i] += value(member);
      result[i] /= static_cast<double>(members.size());
    }
    return result;
  }
};

glm::dvec3 sum(const Vectors& values, std::span<const std::uint32_t> which) {
  glm::dvec3 total(0.0);
  for (const std::uint32_t i : which) total += values[i];
  return total;
}

/// Normals for the points of `to`, taken from `from` as pc_error does, but of unit length.
Vectors transferred_normals(const Side& from, const Side& to, const NearestPoints& from_to,
                            const NearestPoints& to_from) {
  Vectors normals(to.size(), glm::dvec3(0.0));
  for (std::size_t i = 0; i < from.size(); ++i) {
    for (const std::uint32_t k : from_to.of(i)) normals[k] += from.normals[i];
  }
  for (std::size_t k = 0; k < to.size(); ++k) {
    normals[k] = direction(normals[k]);
    if (!is_known(normals[k])) normals[k] = direction(sum(from.normals, to_from.of(k)));
  }
  return normals;
}

/// The input for comparing in one direction.
struct Way {
  const Side& from;
  const Side& to;
  const NearestPoints& nearest;
  const Vectors& plane_normals;  ///< the normals of `to`; empty if there are none
};

void compare_geometry(const Way& way, OneWayDistance& result) {
  double total = 0.0, largest = 0.0, plane_total = 0.0;
  std::size_t with_plane = 0;
  for (std::size_t i = 0; i < way.from.size(); ++i) {
    const auto points = static_cast<double>(way.from.distinct.at(i).size());
    const double squared = way.nearest.squared_distances[i];
    total += points * squared;
    largest = std::max(largest, squared);
    if (way.plane_normals.empty()) continue;
    double plane = 0.0;
    std::size_t known = 0;
    for (const std::uint32_t k : way.nearest.of(i)) {
      if (!is_known(way.plane_normals[k])) continue;
      const double off = glm::dot(way.from.distinct.positions[i] - way.to.distinct.positions[k],
                                  way.plane_normals[k]);
      plane += off * off;
      ++known;
    }
    if (known == 0) {
      result.plane_unknown += way.from.distinct.at(i).size();
      continue;
    }
    plane_total += points * plane / static_cast<double>(known);
    with_plane += way.from.distinct.at(i).size();
  }
  result.mean_squared = total / static_cast<double>(way.from.cloud.size());
  result.max = std::sqrt(largest);
  if (with_plane > 0) result.plane_mean_squared = plane_total / static_cast<double>(with_plane);
}

void compare_colors(const Way& way, OneWayDistance& result) {
  glm::dvec3 total(0.0);
  for (std::size_t i = 0; i < way.from.size(); ++i) {
    const auto neighbors = way.nearest.of(i);
    const glm::dvec3 other = sum(way.to.colors, neighbors) / static_cast<double>(neighbors.size());
    for (const std::uint32_t member : way.from.distinct.at(i)) {
      const glm::dvec3 off = to_ycbcr(glm::dvec3(way.from.cloud.colors[member])) - other;
      total += off * off;
    }
  }
  result.colors = total / static_cast<double>(way.from.cloud.size());
}

void compare_normals(const Way& way, OneWayDistance& result) {
  AngleError error;
  std::vector<double> angles;
  angles.reserve(way.from.cloud.size());
  double total = 0.0;
  for (std::size_t i = 0; i < way.from.size(); ++i) {
    const glm::dvec3 other = direction(sum(way.to.normals, way.nearest.of(i)));
    for (const std::uint32_t member : way.from.distinct.at(i)) {
      const glm::dvec3 own(way.from.cloud.normals[member]);
      if (!is_known(own) || !is_known(other)) {
        ++error.unknown;
        continue;
      }
      angles.push_back(std::atan2(glm::length(glm::cross(own, other)), glm::dot(own, other)));
      total += angles.back();
    }
  }
  if (angles.empty()) return;
  error.mean = total / static_cast<double>(angles.size());
  error.percentile_95 = percentile(angles, 0.95);
  result.normals = error;
}

OneWayDistance compare(const Way& way) {
  OneWayDistance result;
  tbb::parallel_invoke([&] { compare_geometry(way, result); },
                       [&] {
                         if (!way.from.colors.empty() && !way.to.colors.empty())
                           compare_colors(way, result);
                       },
                       [&] {
                         if (!way.from.normals.empty() && !way.to.normals.empty())
                           compare_normals(way, result);
                       });
  return result;
}

/// By how much the distances to equally near points may differ, because coordinates are rounded to
/// float.
double rounding(const PointCloud& a, const PointCloud& b) {
  float largest = 0.0f;
  for (const PointCloud* cloud : {&a, &b}) {
    for (const glm::vec3& p : cloud->positions) {
      largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    }
  }
  return 2.0 * static_cast<double>(largest) * 0x1p-23;
}

}  // namespace

double CloudDistance::d1() const { return std::max(a_to_b.mean_squared, b_to_a.mean_squared); }

std::optional<double> CloudDistance::d2() const {
  if (!a_to_b.plane_mean_squared || !b_to_a.plane_mean_squared) return std::nullopt;
  return std::max(*a_to_b.plane_mean_squared, *b_to_a.plane_mean_squared);
}

double CloudDistance::max() const { return std::max(a_to_b.max, b_to_a.max); }

std::optional<ColorError> CloudDistance::colors() const {
  if (!a_to_b.colors || !b_to_a.colors) return std::nullopt;
  return glm::max(*a_to_b.colors, *b_to_a.colors);
}

std::optional<AngleError> CloudDistance::normals() const {
  if (!a_to_b.normals || !b_to_a.normals) return std::nullopt;
  const AngleError &a = *a_to_b.normals, &b = *b_to_a.normals;
  return AngleError{std::max(a.mean, b.mean), std::max(a.percentile_95, b.percentile_95),
                    a.unknown + b.unknown};
}

double geometry_psnr(double mean_squared, double peak) {
  return 10.0 * std::log10(3.0 * peak * peak / mean_squared);
}

glm::dvec3 color_psnr(const ColorError& mean_squared) {
  const auto psnr = [](double e) { return 10.0 * std::log10(255.0 * 255.0 / e); };
  return {psnr(mean_squared.x), psnr(mean_squared.y), psnr(mean_squared.z)};
}

double yuv_psnr(const glm::dvec3& psnr) { return (6.0 * psnr.x + psnr.y + psnr.z) / 8.0; }

Result<CloudDistance> cloud_distance(const PointCloud& a, const PointCloud& b) {
  if (a.empty() || b.empty())
    return fail(ErrorCode::argument, "a cloud without points cannot be compared");
  // The clouds may have different origins, both far from zero.
  Box box = bounds(a);
  box.grow(bounds(b));
  const Cube cube = bounding_cube(box);
  const double tolerance = rounding(a, b);
  std::optional<Side> side_a, side_b;
  tbb::parallel_invoke([&] { side_a.emplace(a, cube); }, [&] { side_b.emplace(b, cube); });
  NearestPoints a_to_b, b_to_a;
  const auto search = [tolerance](const Side& from, const Side& to, NearestPoints& nearest) {
    nearest = nearest_points(from.distinct.positions, to.distinct.positions, tolerance);
  };
  tbb::parallel_invoke([&] { search(*side_a, *side_b, a_to_b); },
                       [&] { search(*side_b, *side_a, b_to_a); });

  Vectors normals_a, normals_b;
  if (a.has_normals()) {
    normals_a = side_a->normals;
    normals_b = transferred_normals(*side_a, *side_b, a_to_b, b_to_a);
  } else if (b.has_normals()) {
    normals_b = side_b->normals;
    normals_a = transferred_normals(*side_b, *side_a, b_to_a, a_to_b);
  }
  CloudDistance distance;
  tbb::parallel_invoke([&] { distance.a_to_b = compare({*side_a, *side_b, a_to_b, normals_b}); },
                       [&] { distance.b_to_a = compare({*side_b, *side_a, b_to_a, normals_a}); });
  return distance;
}

DistanceSummary summarize(std::span<const double> distances) {
  DistanceSummary summary;
  if (distances.empty()) return summary;
  std::vector<double> values(distances.begin(), distances.end());
  for (const double distance : values) summary.mean += distance;
  summary.mean /= static_cast<double>(values.size());
  summary.percentile_95 = percentile(values, 0.95);
  summary.percentile_999 = percentile(values, 0.999);
  summary.max = *std::max_element(values.begin(), values.end());
  return summary;
}

}  // namespace pointreel
