#include "tests/bench/render/truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include <tbb/parallel_for.h>

#include "client/render/view.h"
#include "common/base/try.h"

namespace pointreel::bench {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// The same values as in client/render/opengl/gl_renderer.cpp and shaders/common.glsl.
const glm::dvec3 kLight = glm::normalize(glm::dvec3(-0.35, 0.45, 1.0));
constexpr double kAmbient = 0.4;

std::uint8_t eight_bits(double c) {
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(c, 0.0, 1.0)));
}

/// Rays through the centres of the pixels.
class Rays {
 public:
  Rays(const Camera& camera, glm::ivec2 size)
      : eye_(camera.eye()), axes_(camera.axes()), size_(size) {
    scale_.y = std::tan(0.5 * camera.fov_y);
    scale_.x = scale_.y * size.x / size.y;
  }

  const glm::dvec3& eye() const { return eye_; }

  Ray through(int x, int y) const {
    const double right = scale_.x * ((2.0 * x + 1.0) / size_.x - 1.0);
    const double up = scale_.y * (1.0 - (2.0 * y + 1.0) / size_.y);
    return {eye_, glm::normalize(axes_ * glm::dvec3(right, up, -1.0))};
  }

  /// Bounds the pixels whose rays may come within `radius` of p: columns and rows from `first` to
  /// `last`. Returns false if there are none.
  bool bound(const glm::dvec3& p, double radius, glm::ivec2& first, glm::ivec2& last) const {
    const glm::dvec3 q = glm::transpose(axes_) * (p - eye_);
    const double depth = -q.z;
    if (depth < -radius) return false;
    if (depth <= 2.0 * radius) {  // the eye is inside, or nearly so
      first = {0, 0};
      last = size_ - 1;
      return true;
    }
    for (int axis = 0; axis < 2; ++axis) {
      // Of the box around the ball, the near or the far face bounds the projection.
      const double sign = axis == 0 ? 1.0 : -1.0;
      const double low = sign * q[axis] - radius, high = sign * q[axis] + radius;
      const double near = depth - radius, far = depth + radius;
      const auto pixel = [&](double x, double z) {
        return 0.5 * size_[axis] * (x / (z * scale_[axis]) + 1.0) - 0.5;
      };
      const double begin = std::floor(std::min(pixel(low, near), pixel(low, far)));
      const double end = std::ceil(std::max(pixel(high, near), pixel(high, far)));
      if (end < 0.0 || begin > size_[axis] - 1.0) return false;
      first[axis] = static_cast<int>(std::max(begin, 0.0));
      last[axis] = static_cast<int>(std::min(end, size_[axis] - 1.0));
    }
    return true;
  }

 private:
  glm::dvec3 eye_;
  glm::dmat3 axes_;
  glm::ivec2 size_;
  glm::dvec2 scale_;
};

/// Divides the picture into small squares. Each knows a distance from the eye before which its rays
/// hit nothing; infinite if they hit nothing at all.
class Tiles {
 public:
  static constexpr int kEdge = 8;

  Tiles(const SurfaceGrid& grid, const Rays& rays, glm::ivec2 size)
      : count_((size + kEdge - 1) / kEdge),
        nearest_(static_cast<std::size_t>(count_.x) * static_cast<std::size_t>(count_.y), kNever) {
    // Half the diagonal of a cell, and some more for rounding.
    constexpr double kRadius = 0.87 * SurfaceGrid::kCell;
    for (const SurfaceGrid::Cell& cell : grid.cells()) {
      const glm::dvec3 center = cell.min + 0.5 * SurfaceGrid::kCell;
      glm::ivec2 first, last;
      if (!rays.bound(center, kRadius, first, last)) continue;
      const double from = std::max(glm::distance(center, rays.eye()) - kRadius, 0.0);
      for (int y = first.y / kEdge; y <= last.y / kEdge; ++y) {
        for (int x = first.x / kEdge; x <= last.x / kEdge; ++x) {
          double& nearest = nearest_[index(x, y)];
          nearest = std::min(nearest, from);
        }
      }
    }
  }

  const glm::ivec2& count() const { return count_; }
  double nearest(int x, int y) const { return nearest_[index(x, y)]; }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(count_.x) +
           static_cast<std::size_t>(x);
  }

  glm::ivec2 count_;
  std::vector<double> nearest_;
};

/// Calls hit(x, y, RayHit) from many threads for every pixel whose ray hits the surface.
template <class Hit>
void cast(const TruthScene& scene, const Camera& camera, glm::ivec2 size, const Hit& hit) {
  const Rays rays(camera, size);
  const Tiles tiles(scene.grid, rays, size);
  tbb::parallel_for(0, tiles.count().y, [&](int tile_y) {
    for (int tile_x = 0; tile_x < tiles.count().x; ++tile_x) {
      const double from = tiles.nearest(tile_x, tile_y);
      if (from == kNever) continue;
      const glm::ivec2 first = Tiles::kEdge * glm::ivec2(tile_x, tile_y);
      const glm::ivec2 end = glm::min(first + Tiles::kEdge, size);
      for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
          if (const auto found = first_hit(scene.grid, rays.through(x, y), from)) hit(x, y, *found);
        }
      }
    }
  });
}

}  // namespace

double linear_from_srgb(double c) {
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

glm::u8vec3 srgb_from_linear(const glm::dvec3& color) {
  glm::u8vec3 srgb;
  for (int i = 0; i < 3; ++i) {
    const double c = color[i];
    srgb[i] = eight_bits(c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055);
  }
  return srgb;
}

glm::dvec3 lit(const glm::dvec3& color, const glm::dvec3& normal, const Camera& camera,
               double strength) {
  const double diffuse = std::max(glm::dot(normal, camera.axes() * kLight), 0.0);
  const double dark = (1.0 - kAmbient) * (1.0 - diffuse);
  return (1.0 - strength * dark) * color;
}

std::optional<RayHit> truth_at(const TruthScene& scene, const Camera& camera, glm::ivec2 size,
                               glm::ivec2 pixel) {
  return first_hit(scene.grid, Rays(camera, size).through(pixel.x, pixel.y));
}

Result<TruthScene> make_truth_scene(Body body) {
  SurfaceGrid grid = TRY(SurfaceGrid::build(body.surface));
  return TruthScene{std::move(body), std::move(grid)};
}

TruthPicture cast_truth(const TruthScene& scene, const Camera& camera, glm::ivec2 size,
                        const TruthStyle& style) {
  const auto pixels = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  const glm::u8vec3 background(eight_bits(style.background.x), eight_bits(style.background.y),
                               eight_bits(style.background.z));
  TruthPicture picture{{size.x, size.y, std::vector<glm::u8vec3>(pixels, background)},
                       Mask(pixels, 0)};
  std::array<double, 256> linear;
  for (std::size_t i = 0; i < linear.size(); ++i) {
    linear[i] = linear_from_srgb(static_cast<double>(i) / 255.0);
  }
  cast(scene, camera, size, [&](int x, int y, const RayHit& hit) {
    glm::dvec3 color;
    if (style.texture) {
      const glm::u8vec3 srgb = color_at(scene.body, hit.primitive, hit.position);
      for (int c = 0; c < 3; ++c) color[c] = linear[srgb[c]];
    } else {  // as fake_color in client/render/instances.h
      for (int c = 0; c < 3; ++c) color[c] = linear_from_srgb(0.5 + 0.5 * hit.normal[c]);
    }
    if (style.lighting) color = lit(color, hit.normal, camera, light_strength(true, style.texture));
    const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) +
                   static_cast<std::size_t>(x);
    picture.image.pixels[i] = srgb_from_linear(color);
    picture.mask[i] = 255;
  });
  return picture;
}

double truth_coverage(const TruthScene& scene, const Camera& camera, glm::ivec2 size) {
  std::vector<int> rows(static_cast<std::size_t>(size.y), 0);
  // No two threads share a row.
  cast(scene, camera, size,
       [&](int, int y, const RayHit&) { ++rows[static_cast<std::size_t>(y)]; });
  double covered = 0.0;
  for (const int row : rows) covered += row;
  return covered / (static_cast<double>(size.x) * size.y);
}

std::vector<bool> hidden_points(const TruthScene& scene, const glm::dvec3& eye,
                                const std::vector<glm::dvec3>& points, double tolerance) {
  std::vector<std::uint8_t> hidden(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    const glm::dvec3 way = points[i] - eye;
    const double length = glm::length(way);
    if (!(length > tolerance)) return;
    hidden[i] = hits_anything(scene.grid, {eye, way / length}, 0.0, length - tolerance);
  });
  return {hidden.begin(), hidden.end()};
}

}  // namespace pointreel::bench
