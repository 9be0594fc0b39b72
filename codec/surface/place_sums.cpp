#include "codec/surface/place_sums.h"

#include <algorithm>
#include <cmath>

#include "pointreel/cpu.h"

namespace pointreel {
namespace {

/// Below this share of the sum of squares, their spread consists of rounding errors.
constexpr float kLaneRounding = 1e-6f;
/// The least square length of the mean normal at which it has a direction.
constexpr float kLeastSquaredNormal = 1e-10f;
/// Below this share of the square of the trace, the cofactors of second moments are rounding
/// errors.
constexpr double kLeastCofactor = 1e-7;
/// Steps of the power iteration for the smallest axis. It begins near it, and each step divides the
/// error by the ratio of the two smallest moments.
constexpr int kAxisSteps = 2;
/// The least square length of a gradient, relative to another, at which it has a direction.
constexpr float kLeastGradient = 1e-10f;

[[gnu::always_inline]] inline std::size_t select(std::span<const PointRow> rows,
                                                 std::span<const std::uint32_t> candidates,
                                                 const glm::vec3& center, float radius,
                                                 std::uint32_t* near) {
  const float square = radius * radius;
  std::size_t count = 0;
  for (const std::uint32_t candidate : candidates) {
    const PointRow& row = rows[candidate];
    const Lanes dx = row.x - center.x, dy = row.y - center.y, dz = row.z - center.z;
    const LaneMask inside = dx * dx + dy * dy + dz * dz < square;
    alignas(sizeof(Lanes)) std::array<std::int32_t, kLanes> hits;
    *reinterpret_cast<LaneMask*>(hits.data()) = inside;
    // Without branches, which could not be predicted.
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      near[count] = row.points[lane];
      count -= static_cast<std::size_t>(std::ptrdiff_t{hits[lane]});
    }
  }
  return count;
}

template <bool kMoments>
[[gnu::always_inline]] inline void sum(std::span<const PointNormal> points,
                                       std::span<const std::uint32_t> near, const Places& places,
                                       PlaceSums& total, PlaceMoments* moments) {
  PlaceSums s;
  PlaceMoments m;
  const float* const first = &points.data()->position.x;
  for (const std::uint32_t i : near) {
    const float* const p = first + std::size_t{i} * 6;
    const Lanes dx = p[0] - places.x, dy = p[1] - places.y, dz = p[2] - places.z;
    const Lanes square = dx * dx + dy * dy + dz * dz;
    const Lanes cosine = p[3] * places.nx + p[4] * places.ny + p[5] * places.nz;
    Lanes weight = 1.0f - square * places.per_square;
    const LaneMask counts = (weight > 0.0f) & (cosine > places.least_cosine);
    weight = weight * weight;
    weight = weight * weight;
    weight = reinterpret_cast<Lanes>(reinterpret_cast<LaneMask>(weight) & counts);
    const Lanes wx = weight * dx, wy = weight * dy, wz = weight * dz;
    s.w += weight;
    s.px += wx;
    s.py += wy;
    s.pz += wz;
    s.nx += weight * p[3];
    s.ny += weight * p[4];
    s.nz += weight * p[5];
    s.pp += weight * square;
    s.pn += wx * p[3] + wy * p[4] + wz * p[5];
    if constexpr (kMoments) {
      m.xx += wx * dx;
      m.yy += wy * dy;
      m.zz += wz * dz;
      m.xy += wx * dy;
      m.yz += wy * dz;
      m.zx += wz * dx;
    }
  }
  total = s;
  if constexpr (kMoments) *moments = m;
}

[[gnu::always_inline]] inline void fit_and_project(const PlaceSums& sums, float beta,
                                                   const Lanes& fx, const Lanes& fy,
                                                   const Lanes& fz, PlacesFound& result) {
  const Lanes zero{};
  const LaneMask any = sums.w > 0.0f;
  const Lanes per_weight = 1.0f / (any ? sums.w : zero + 1.0f);
  const Lanes px = sums.px * per_weight, py = sums.py * per_weight, pz = sums.pz * per_weight;
  const Lanes nx = sums.nx * per_weight, ny = sums.ny * per_weight, nz = sums.nz * per_weight;
  const Lanes pp = sums.pp * per_weight, pn = sums.pn * per_weight;
  LaneMask found = any & (nx * nx + ny * ny + nz * nz > kLeastSquaredNormal);
  const Lanes spread = pp - (px * px + py * py + pz * pz);
  const LaneMask spreads = spread > kLaneRounding * pp;
  const Lanes u4 = spreads ? 0.5f * beta * (pn - (px * nx + py * ny + pz * nz)) /
                                 (spreads ? spread : zero + 1.0f)
                           : zero;
  const Lanes ux = nx - 2.0f * u4 * px, uy = ny - 2.0f * u4 * py, uz = nz - 2.0f * u4 * pz;
  const Lanes u0 = -(ux * px + uy * py + uz * pz) - u4 * pp;

  const Lanes gx = ux + 2.0f * u4 * fx, gy = uy + 2.0f * u4 * fy, gz = uz + 2.0f * u4 * fz;
  const Lanes slope_square = gx * gx + gy * gy + gz * gz;
  found &= slope_square > 0.0f;
  Lanes slope = found ? slope_square : zero + 1.0f;
  take_roots(slope);
  const Lanes value = u0 + (ux * fx + uy * fy + uz * fz) + u4 * (fx * fx + fy * fy + fz * fz);
  const Lanes discriminant = slope_square - 4.0f * u4 * value;
  Lanes root = (found & (discriminant > 0.0f)) ? discriminant : zero;
  take_roots(root);
  const Lanes t = -2.0f * value / (slope + root) / slope;
  result.x = fx + gx * t;
  result.y = fy + gy * t;
  result.z = fz + gz * t;
  // The normal is along the gradient at the point found.
  const Lanes turn = 1.0f + 2.0f * u4 * t;
  // At the centre of a sphere every direction is normal; the one that leads there serves as well.
  const Lanes sign = turn < 0.0f ? zero - 1.0f : zero + 1.0f;
  const Lanes per_slope = (turn * turn > kLeastGradient ? sign : zero + 1.0f) / slope;
  result.nx = gx * per_slope;
  result.ny = gy * per_slope;
  result.nz = gz * per_slope;
  result.found = found;
}

// The variants give the same to the bit, because the lanes are the same and nothing is contracted.
#if defined(__x86_64__)
[[gnu::target("avx2")]] std::size_t select_avx2(std::span<const PointRow> rows,
                                                std::span<const std::uint32_t> candidates,
                                                const glm::vec3& center, float radius,
                                                std::uint32_t* near) {
  return select(rows, candidates, center, radius, near);
}
[[gnu::target("avx2")]] void sum_avx2(std::span<const PointNormal> points,
                                      std::span<const std::uint32_t> near, const Places& places,
                                      PlaceSums& total) {
  sum<false>(points, near, places, total, nullptr);
}
[[gnu::target("avx2")]] void sum_moments_avx2(std::span<const PointNormal> points,
                                              std::span<const std::uint32_t> near,
                                              const Places& places, PlaceSums& total,
                                              PlaceMoments& moments) {
  sum<true>(points, near, places, total, &moments);
}
[[gnu::target("avx2")]] void project_avx2(const PlaceSums& sums, float beta, const Lanes& fx,
                                          const Lanes& fy, const Lanes& fz, PlacesFound& result) {
  fit_and_project(sums, beta, fx, fy, fz, result);
}
bool has_avx2() { return (cpu_features() & kCpuAvx2) != 0; }
#endif

}  // namespace

std::size_t select_points(std::span<const PointRow> rows, std::span<const std::uint32_t> candidates,
                          const glm::vec3& center, float radius, std::vector<std::uint32_t>& near) {
  // One more, because a number is written before it is known whether it stays.
  if (near.size() < candidates.size() * kLanes + 1) near.resize(candidates.size() * kLanes + 1);
#if defined(__x86_64__)
  if (has_avx2()) return select_avx2(rows, candidates, center, radius, near.data());
#endif
  return select(rows, candidates, center, radius, near.data());
}

PlaceSums sum_around(std::span<const PointNormal> points, std::span<const std::uint32_t> near,
                     const Places& places, PlaceMoments* moments) {
  PlaceSums total;
#if defined(__x86_64__)
  if (has_avx2()) {
    if (moments != nullptr) {
      sum_moments_avx2(points, near, places, total, *moments);
    } else {
      sum_avx2(points, near, places, total);
    }
    return total;
  }
#endif
  if (moments != nullptr) {
    sum<true>(points, near, places, total, moments);
  } else {
    sum<false>(points, near, places, total, nullptr);
  }
  return total;
}

PlacesFound project_onto_spheres(const PlaceSums& sums, float beta, const Lanes& fx,
                                 const Lanes& fy, const Lanes& fz) {
  PlacesFound result;
#if defined(__x86_64__)
  if (has_avx2()) {
    project_avx2(sums, beta, fx, fy, fz, result);
    return result;
  }
#endif
  fit_and_project(sums, beta, fx, fy, fz, result);
  return result;
}

SphereSums PlaceSums::at(std::size_t lane) const {
  SphereSums sums;
  sums.w = w[lane];
  sums.p = {px[lane], py[lane], pz[lane]};
  sums.n = {nx[lane], ny[lane], nz[lane]};
  sums.pp = pp[lane];
  sums.pn = pn[lane];
  return sums;
}

SecondMoments::SecondMoments(const PlaceMoments& moments, std::size_t lane)
    : xx_(moments.xx[lane]),
      yy_(moments.yy[lane]),
      zz_(moments.zz[lane]),
      xy_(moments.xy[lane]),
      yz_(moments.yz[lane]),
      zx_(moments.zx[lane]) {}

SecondMoments SecondMoments::around(const glm::dvec3& p, double w) const {
  SecondMoments moments;
  moments.xx_ = xx_ - p.x * p.x / w;
  moments.yy_ = yy_ - p.y * p.y / w;
  moments.zz_ = zz_ - p.z * p.z / w;
  moments.xy_ = xy_ - p.x * p.y / w;
  moments.yz_ = yz_ - p.y * p.z / w;
  moments.zx_ = zx_ - p.z * p.x / w;
  return moments;
}

glm::dmat3 SecondMoments::cofactors() const {
  const double xx = yy_ * zz_ - yz_ * yz_, yy = xx_ * zz_ - zx_ * zx_, zz = xx_ * yy_ - xy_ * xy_;
  const double xy = yz_ * zx_ - xy_ * zz_, yz = xy_ * zx_ - xx_ * yz_, zx = xy_ * yz_ - yy_ * zx_;
  return {xx, xy, zx, xy, yy, yz, zx, yz, zz};
}

double SecondMoments::least_along(const glm::dvec3& normal) const {
  const glm::dmat3 moments(xx_, xy_, zx_, xy_, yy_, yz_, zx_, yz_, zz_);
  // Restricted to the plane, the matrix has this trace and this determinant.
  const double trace = xx_ + yy_ + zz_ - glm::dot(normal, moments * normal);
  const double determinant = glm::dot(normal, cofactors() * normal);
  return 0.5 * (trace - std::sqrt(std::max(0.0, trace * trace - 4.0 * determinant)));
}

std::optional<glm::dvec3> SecondMoments::least_axis(const glm::dvec3& normal) const {
  // The matrix of cofactors has the same axes, and the smallest moment's is its largest.
  const glm::dmat3 matrix = cofactors();
  const double trace = xx_ + yy_ + zz_;
  glm::dvec3 axis = normal;
  for (int step = 0; step < kAxisSteps; ++step) {
    const double before = glm::length(axis);
    if (!(before > 0.0)) return std::nullopt;
    axis = matrix * (axis / before);
    if (!(glm::length(axis) > kLeastCofactor * trace * trace)) return std::nullopt;
  }
  axis = glm::normalize(axis);
  return glm::dot(axis, normal) < 0.0 ? -axis : axis;
}

}  // namespace pointreel
