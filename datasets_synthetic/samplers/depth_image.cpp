#include "datasets_synthetic/samplers/depth_image.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "datasets_synthetic/ray_cast.h"
#include "datasets_synthetic/samplers/depth_range.h"
#include "datasets_synthetic/samplers/smooth_noise.h"
#include "datasets_synthetic/vectors.h"

// A pixel of a real camera sees a small area, not a point. Where neighbouring rays meet different
// surfaces, rays through the corners of the pixel tell how much of each surface it sees. Elsewhere
// the ray through its middle is enough.

namespace pointreel {
namespace {

/// Weights of the rays through the middle and through each corner.
constexpr double kMiddleWeight = 2.0, kCornerWeight = 1.0;
constexpr double kAllWeight = kMiddleWeight + 4.0 * kCornerWeight;
/// The least share of a pixel that a surface before an empty background must cover to be measured.
constexpr double kLeastCover = 0.3;
/// The cosine that stands for the slant where a pixel sees several surfaces.
constexpr double kMixedCosine = 0.5;
/// Normals are estimated from a window of 2 * this + 1 pixels squared.
constexpr int kNormalReach = 2;
constexpr double kNearest = 0.1;  // metres; cameras measure nothing nearer

}  // namespace

/// Fills an image.
class DepthImage::Taking {
 public:
  Taking(DepthImage& image, const SurfaceGrid& grid, const DepthCameraOptions& options,
         double distance, std::uint64_t seed)
      : image_(image),
        grid_(grid),
        options_(options),
        distance_(distance),
        seed_(seed),
        range_(grid, image.view_, options.half_field),
        noise_(Random(seed, 0).bits(), options.grain),
        slant_(Random(seed, 1).bits(), options.grain),
        flakes_(Random(seed, 2).bits()) {}

  void run() {
    crop();
    image_.pixels_.resize(area(0));
    middles_.resize(area(0));
    corners_.resize(area(1), {kUnknown});
    look_everywhere();
    find_edges();
    for (int y = image_.bottom(); y < image_.top(); ++y) {
      for (int x = image_.left(); x < image_.right(); ++x) measure(x, y);
    }
  }

 private:
  /// What a ray meets.
  struct Sight {
    double depth = 0.0;   ///< 0: nothing
    double cosine = 0.0;  ///< between the normal and the ray
    glm::vec3 normal{0.0f};

    bool hit() const { return depth > 0.0; }
  };
  static constexpr double kUnknown = -1.0;  // the depth of a ray that has not been cast

  /// What a pixel sees: how much of it the nearest surface covers, and what lies behind.
  struct Mix {
    double cover = 1.0;
    double front = 0.0;  ///< depth
    double back = 0.0;   ///< depth of other surfaces; 0: there are none
  };

  std::size_t area(int more) const {
    return static_cast<std::size_t>(image_.width_ + more) *
           static_cast<std::size_t>(image_.height_ + more);
  }

  /// Chooses the part of the image that holds all tiles with surface, and one pixel around it.
  void crop() {
    int x0 = range_.tiles(), y0 = x0, x1 = -1, y1 = -1;
    for (int y = 0; y < range_.tiles(); ++y) {
      for (int x = 0; x < range_.tiles(); ++x) {
        if (range_.at(x, y).empty()) continue;
        x0 = std::min(x0, x), x1 = std::max(x1, x);
        y0 = std::min(y0, y), y1 = std::max(y1, y);
      }
    }
    if (x1 < 0) return;
    const auto side = static_cast<int>(2.0 * image_.half_field_ / image_.pitch_);
    const auto pixel = [&](int tile, int more) {
      const double at = (range_.tile_begin(tile) + image_.half_field_) / image_.pitch_;
      return std::clamp(static_cast<int>(std::floor(at)) + more, 0, side);
    };
    image_.left_ = pixel(x0, -1), image_.bottom_ = pixel(y0, -1);
    image_.width_ = pixel(x1 + 1, 2) - image_.left_;
    image_.height_ = pixel(y1 + 1, 2) - image_.bottom_;
  }

  Sight look(double x, double y) const {
    if (!(std::abs(x) < options_.half_field && std::abs(y) < options_.half_field)) return {};
    const DepthRange::Range& range = range_.at(range_.tile_of(x), range_.tile_of(y));
    if (range.empty()) return {};
    const glm::dvec3 way = image_.view_.toward(x, y);
    const double length = std::sqrt(glm::dot(way, way));
    const Ray ray{image_.view_.position, way / length};
    const auto hit = first_hit(grid_, ray, range.near, range.far);
    if (!hit) return {};
    return {hit->t / length, -glm::dot(hit->normal, ray.direction), glm::vec3(hit->normal)};
  }

  Sight& middle(int x, int y) { return middles_[image_.index(x, y)]; }
  const Sight& middle(int x, int y) const { return middles_[image_.index(x, y)]; }

  /// Finds what the ray through the middle of each pixel meets. Rays are cast for every second
  /// pixel of every second row. Where those around another pixel meet the same smooth piece of
  /// the surface, so does that pixel's ray.
  void look_everywhere() {
    for (int y = image_.bottom(); y < image_.top(); y += 2) {
      for (int x = image_.left(); x < image_.right(); x += 2) {
        middle(x, y) = look(image_.place(x), image_.place(y));
      }
    }
    for (int y = image_.bottom(); y < image_.top(); ++y) {
      for (int x = image_.left(); x < image_.right(); ++x) {
        const int i = (x - image_.left()) % 2, j = (y - image_.bottom()) % 2;
        if (i + j > 0 && !look_between(x, y, i, j)) {
          middle(x, y) = look(image_.place(x), image_.place(y));
        }
      }
    }
  }

  /// Finds what a ray meets from the rays (+-i, +-j) pixels away; false if they do not tell.
  bool look_between(int x, int y, int i, int j) {
    if (x + i >= image_.right() || y + j >= image_.top()) return false;
    const Sight &a = middle(x - i, y - j), &b = middle(x + i, y + j);
    const Sight &c = middle(x - i, y + j), &d = middle(x + i, y - j);
    if (!smooth(a, b) || !smooth(c, d) || !smooth(a, c)) return false;
    const double depth = 0.25 * (a.depth + b.depth + c.depth + d.depth);
    const glm::dvec3 way = image_.ray(x, y);
    const auto hit = hit_near(grid_, image_.view_.position, way, depth);
    if (!hit || std::abs(hit->depth - depth) > 0.5 * image_.jump_at(depth)) return false;
    const glm::dvec3 normal = unit(hit->gradient);
    middle(x, y) = {hit->depth, -glm::dot(normal, unit(way)), glm::vec3(normal)};
    return true;
  }

  bool smooth(const Sight& a, const Sight& b) const {
    return a.hit() && b.hit() && !apart(a, b) && glm::dot(a.normal, b.normal) > 0.75f;
  }

  /// Marks the pixels at edges and counts them.
  void find_edges() {
    const auto row = static_cast<std::size_t>(image_.width_ + 1);
    image_.edges_.assign(area(1), 0);
    for (int y = image_.bottom(); y < image_.top(); ++y) {
      std::uint32_t count = 0;
      for (int x = image_.left(); x < image_.right(); ++x) {
        const double depth = middle(x, y).depth;
        if (depth > 0.0) {
          image_.nearest_ = image_.nearest_ > 0.0 ? std::min(image_.nearest_, depth) : depth;
        }
        DepthPixel& pixel = image_.pixels_[image_.index(x, y)];
        pixel.seen = depth;
        pixel.edge = at_edge(x, y);
        if (pixel.edge) ++count;
        const std::size_t corner = image_.corner(x, y);
        image_.edges_[corner + row + 1] = image_.edges_[corner + 1] + count;
      }
    }
  }

  /// What the ray through the lower left corner of a pixel meets; each ray is cast once.
  const Sight& corner(int x, int y) {
    Sight& sight = corners_[image_.corner(x, y)];
    if (sight.depth == kUnknown) {
      sight = look(x * image_.pitch_ - image_.half_field_, y * image_.pitch_ - image_.half_field_);
    }
    return sight;
  }

  bool apart(const Sight& a, const Sight& b) const {
    if (a.hit() != b.hit()) return true;
    return a.hit() && std::abs(a.depth - b.depth) > image_.jump_at(std::min(a.depth, b.depth));
  }

  /// Whether a neighbour of the pixel sees another surface.
  bool at_edge(int x, int y) const {
    const Sight& here = middle(x, y);
    for (int j = std::max(y - 1, image_.bottom()); j < std::min(y + 2, image_.top()); ++j) {
      for (int i = std::max(x - 1, image_.left()); i < std::min(x + 2, image_.right()); ++i) {
        if (apart(here, middle(i, j))) return true;
      }
    }
    return false;
  }

  Mix mix(int x, int y) {
    const std::array<Sight, 5> sights{middle(x, y), corner(x, y), corner(x + 1, y),
                                      corner(x, y + 1), corner(x + 1, y + 1)};
    Mix mix;
    for (const Sight& sight : sights) {
      if (sight.hit() && (mix.front == 0.0 || sight.depth < mix.front)) mix.front = sight.depth;
    }
    if (mix.front == 0.0) return mix;
    const double limit = mix.front + image_.jump_at(mix.front);
    double front = 0.0, front_weight = 0.0, back = 0.0, back_weight = 0.0;
    for (std::size_t i = 0; i < sights.size(); ++i) {
      if (!sights[i].hit()) continue;
      const double weight = i == 0 ? kMiddleWeight : kCornerWeight;
      const bool near = sights[i].depth <= limit;
      (near ? front : back) += weight * sights[i].depth;
      (near ? front_weight : back_weight) += weight;
    }
    mix.cover = front_weight / kAllWeight;
    mix.front = front / front_weight;
    if (back_weight > 0.0) mix.back = back / back_weight;
    return mix;
  }

  /// Whether the camera mixes depths at edges here. It does so in whole grains, so that flakes hang
  /// from the silhouettes rather than single points.
  bool mixes(int x, int y) const {
    const auto grain = static_cast<std::uint64_t>(y / options_.grain) << 32 |
                       static_cast<std::uint64_t>(x / options_.grain);
    return Random(flakes_, grain).uniform() < options_.flying;
  }

  void measure(int x, int y) {
    DepthPixel& pixel = image_.pixels_[image_.index(x, y)];
    const Sight& seen = middle(x, y);
    if (!seen.hit() && !pixel.edge) return;
    Random random(seed_, static_cast<std::uint64_t>(y) << 32 | static_cast<std::uint32_t>(x));
    if (pixel.edge && mixes(x, y)) {
      const Mix mixed = mix(x, y);
      if (mixed.cover < 1.0) {
        fly(mixed, random, pixel);
        if (pixel.flying) disturb(x, y, kMixedCosine, random, pixel);
        return;
      }
    }
    const double limit = options_.least_cosine + options_.least_cosine_varies * slant_.at(x, y);
    if (!seen.hit() || seen.cosine < limit) return;
    pixel.truth = pixel.measured = seen.depth;
    disturb(x, y, seen.cosine, random, pixel);
  }

  /// Mixes the depths of a pixel at an edge, unless too little of it is covered.
  void fly(const Mix& seen, Random& random, DepthPixel& pixel) const {
    // Five rays tell the cover only roughly.
    const double cover = std::clamp(seen.cover + (random.uniform() - 0.5) / kAllWeight, 0.0, 1.0);
    const double open = 1.0 - cover;
    if (seen.back > 0.0) {
      pixel.measured = cover * seen.front + open * seen.back;
    } else {
      if (cover < kLeastCover) return;
      pixel.measured = seen.front + options_.flying_reach * open * open;
    }
    pixel.truth = seen.front;
    pixel.flying = true;
  }

  /// Adds noise to a depth and rounds it to a step of disparity.
  void disturb(int x, int y, double cosine, Random& random, DepthPixel& pixel) const {
    const double sigma = image_.noise_at(pixel.measured) / std::max(cosine, options_.least_cosine);
    double depth =
        pixel.measured + sigma * (std::sqrt(options_.noise_smooth) * noise_.at(x, y) +
                                  std::sqrt(1.0 - options_.noise_smooth) * quick_normal(random));
    if (options_.depth_step > 0.0) {
      const double scale = distance_ * distance_ / options_.depth_step;
      depth = scale / std::max(std::floor(scale / depth + 0.5), 1.0);
    }
    if (depth < kNearest) {
      pixel.measured = 0.0;
      return;
    }
    pixel.measured = depth;
  }

  DepthImage& image_;
  const SurfaceGrid& grid_;
  const DepthCameraOptions& options_;
  double distance_;
  std::uint64_t seed_;
  DepthRange range_;
  SmoothNoise noise_, slant_;
  std::uint64_t flakes_;        ///< the seed of where depths are mixed
  std::vector<Sight> middles_;  ///< one for each pixel
  std::vector<Sight> corners_;  ///< one for each lower left corner, and one row and column more
};

DepthImage::DepthImage(const Pinhole& view, const DepthCameraOptions& options, double distance)
    : view_(view),
      half_field_(options.half_field),
      pitch_(options.pixel / distance),
      noise_(options.noise / (distance * distance)) {}

DepthImage DepthImage::take(const SurfaceGrid& grid, const Pinhole& view,
                            const DepthCameraOptions& options, double distance,
                            std::uint64_t seed) {
  DepthImage image(view, options, distance);
  Taking(image, grid, options, distance, seed).run();
  return image;
}

bool DepthImage::anything_before(double depth, int x0, int y0, int x1, int y1) const {
  x0 = std::max(x0, left()), x1 = std::min(x1 + 1, right());
  y0 = std::max(y0, bottom()), y1 = std::min(y1 + 1, top());
  const std::uint32_t edges = edges_[corner(x1, y1)] + edges_[corner(x0, y0)] -
                              edges_[corner(x0, y1)] - edges_[corner(x1, y0)];
  if (edges == 0) return false;
  constexpr int kSteps = 8;  // along each side, at most
  const int step_x = (x1 - x0 - 1) / kSteps + 1, step_y = (y1 - y0 - 1) / kSteps + 1;
  const double limit = depth - jump_at(depth);
  for (int y = y0; y < y1; y += step_y) {
    for (int x = x0; x < x1; x += step_x) {
      const double seen = at(x, y).seen;
      if (seen > 0.0 && seen < limit) return true;
    }
  }
  return false;
}

double DepthImage::jump_at(double depth) const { return std::max(0.02, 5.0 * pitch_ * depth); }

glm::dvec3 DepthImage::normal(int x, int y) const {
  const double depth = at(x, y).measured;
  const double limit = jump_at(depth) + 4.0 * noise_at(depth);
  // The least squares fit of depth = middle + across * i + along * j.
  double n = 0.0, si = 0.0, sj = 0.0, sz = 0.0;
  double sii = 0.0, sij = 0.0, sjj = 0.0, siz = 0.0, sjz = 0.0;
  for (int v = std::max(y - kNormalReach, bottom()); v <= std::min(y + kNormalReach, top() - 1);
       ++v) {
    for (int u = std::max(x - kNormalReach, left()); u <= std::min(x + kNormalReach, right() - 1);
         ++u) {
      const double z = at(u, v).measured - depth;
      if (at(u, v).measured == 0.0 || std::abs(z) > limit) continue;
      const double i = u - x, j = v - y;
      n += 1.0, si += i, sj += j, sz += z;
      sii += i * i, sij += i * j, sjj += j * j, siz += i * z, sjz += j * z;
    }
  }
  const double a = n * sii - si * si, b = n * sij - si * sj, c = n * sjj - sj * sj;
  const double p = n * siz - si * sz, q = n * sjz - sj * sz;
  const double determinant = a * c - b * b;  // an integer; 0 if all pixels are in one line
  const glm::dvec3 way = ray(x, y);
  if (determinant < 0.5) return -unit(way);
  const double across = (p * c - q * b) / determinant, along = (q * a - p * b) / determinant;
  const glm::dvec3 normal = unit(glm::cross(across * way + depth * pitch_ * view_.right,
                                            along * way + depth * pitch_ * view_.up));
  return glm::dot(normal, way) > 0.0 ? -normal : normal;
}

}  // namespace pointreel
