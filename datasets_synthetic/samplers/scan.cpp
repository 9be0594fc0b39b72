#include "datasets_synthetic/samplers/scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <tbb/parallel_for.h>

#include "common/base/try.h"
#include "datasets_synthetic/random.h"
#include "datasets_synthetic/ray_cast.h"
#include "datasets_synthetic/samplers/depth_range.h"
#include "datasets_synthetic/samplers/measurement_error.h"
#include "datasets_synthetic/surface_grid.h"

// A curve of the pattern is followed by rays from its projector, in steps of a few pixels, and in
// shorter steps where it bends or breaks off. Between two rays that hit the same piece of the
// surface, the depth is interpolated from the depths and normals at both ends and corrected by
// Newton's method. So a point costs one or two evaluations of the distance instead of two rays.

namespace pointreel {
namespace {

/// The uses of random numbers; each has its own streams.
enum class ScanUse : std::uint64_t { phase, calibration, patches, curve };

/// The number of the stream for one use; `which` is below 2^48.
std::uint64_t stream(ScanUse use, std::uint64_t which) {
  return static_cast<std::uint64_t>(use) << 48 | which;
}

/// A point of a curve that its projector lights.
struct Lit {
  double along = 0.0;  ///< its coordinate along the curve in the projector's picture
  double depth = 0.0;  ///< along the projector's axis; 0 if the curve breaks off here
  double slope = 0.0;  ///< derivative of the depth
  glm::dvec3 position{0.0}, normal{0.0};
  bool between = false;  ///< no ray was cast; it counts as lit because both its neighbours are

  bool lit() const { return depth > 0.0; }
};

/// The rays along a curve: the pixels from one ray to the next, the largest distance in metres, and
/// how often this distance is halved where the curve bends or breaks off. Where the curve is
/// smooth, an interpolated point, which costs no ray, replaces the first halving.
constexpr double kStepPixels = 8.0;
constexpr double kLongestStep = 0.02;
constexpr int kHalvings = 3;
/// How often the interval between a visible and a hidden point is halved to find where it ends.
constexpr int kHidingHalvings = 2;

struct Ball {
  glm::dvec3 center;
  double radius;

  bool holds(const glm::dvec3& p) const {
    const glm::dvec3 d = p - center;
    return glm::dot(d, d) < radius * radius;
  }
};

/// Three overlapping balls, which look less regular than a single one.
struct Patch {
  Ball around;
  std::array<Ball, 3> balls;
};

/// The data that all curves of a frame share.
struct Scene {
  const Body& body;
  const SurfaceGrid& grid;
  const ScanOptions& options;
  Rig rig;
  double distance;  ///< working distance
  std::vector<DepthRange> projector_ranges, camera_ranges;
  std::vector<Calibration> calibrations;  ///< one for each pair
  std::vector<Patch> patches;
  std::uint64_t frame_seed;
};

double luminance(const glm::u8vec3& color) {
  return (0.2126 * color.r + 0.7152 * color.g + 0.0722 * color.b) / 255.0;
}

/// Follows one curve and adds the points that each camera measures on it.
class Curve {
 public:
  Curve(const Scene& scene, std::size_t projector, int family, std::int32_t number, double across)
      : scene_(scene),
        view_(scene.rig.projectors[projector]),
        range_(scene.projector_ranges[projector]),
        projector_(projector),
        family_(family),
        number_(number),
        across_(across) {}

  void trace(std::vector<ScanPoint>& points) {
    light();
    if (lit_.empty()) return;
    for (std::size_t pair = 0; pair < scene_.rig.pairs.size(); ++pair) {
      if (scene_.rig.pairs[pair].projector == projector_) observe(pair, points);
    }
  }

 private:
  glm::dvec3 toward(double along) const {
    return family_ == 0 ? view_.toward(across_, along) : view_.toward(along, across_);
  }
  /// The derivative of toward() along the curve.
  const glm::dvec3& change() const { return family_ == 0 ? view_.up : view_.right; }

  /// Casts the rays and fills lit_ with the points of the curve, and with a Lit of depth 0 wherever
  /// it breaks off.
  void light() {
    const double half = scene_.options.rig.half_field;
    const double step =
        std::min(kStepPixels * scene_.options.pixel, kLongestStep) / scene_.distance;
    const int fixed = range_.tile_of(across_);
    const auto steps = static_cast<int>(2.0 * half / step);
    Lit before{.along = -half};
    for (int i = 0; i < steps; ++i) {
      const double along = -half + (i + 0.5) * step;
      const int tile = range_.tile_of(along);
      const bool empty = (family_ == 0 ? range_.at(fixed, tile) : range_.at(tile, fixed)).empty();
      const Lit now = empty ? Lit{.along = along} : light_at(along);
      add_between(before, now, kHalvings);
      before = now;
      if (empty) {  // skip to the last step of this tile
        i = std::max(i, static_cast<int>((range_.tile_begin(tile + 1) + half) / step - 0.5));
        before.along = -half + (i + 0.5) * step;
      }
    }
    add_gap();
  }

  Lit light_at(double along) const {
    Lit lit{.along = along};
    const int fixed = range_.tile_of(across_), tile = range_.tile_of(along);
    const DepthRange::Range range = family_ == 0 ? range_.at(fixed, tile) : range_.at(tile, fixed);
    const glm::dvec3 way = toward(along);
    const double length = std::sqrt(glm::dot(way, way));
    const Ray ray{view_.position, way / length};
    const auto hit = first_hit(scene_.grid, ray, range.near, range.far);
    const double cosine = hit ? -glm::dot(hit->normal, ray.direction) : 0.0;
    if (cosine < scene_.options.least_cosine) return lit;
    lit.depth = hit->t / length;
    // The point moves in the tangent plane of the surface: n . (depth * way)' = 0.
    lit.slope = lit.depth * glm::dot(hit->normal, change()) / (cosine * length);
    lit.position = hit->position;
    lit.normal = hit->normal;
    return lit;
  }

  /// Adds b, which comes after a, and the points that are needed between them.
  void add_between(const Lit& a, const Lit& b, int halvings) {
    if (!a.lit() && !b.lit()) return;
    const bool both = a.lit() && b.lit();
    const bool smooth = both && connected(a, b) && glm::dot(a.normal, b.normal) > 0.9;
    if (smooth && halvings == kHalvings) {
      const Lit middle = between(a, b);
      if (middle.lit()) {
        lit_.push_back(middle);
        lit_.push_back(b);
        return;
      }
    }
    if (halvings > 0 && !smooth) {
      const Lit middle = light_at(0.5 * (a.along + b.along));
      add_between(a, middle, halvings - 1);
      add_between(middle, b, halvings - 1);
      return;
    }
    if (!both || !connected(a, b)) add_gap();
    if (b.lit()) lit_.push_back(b);
  }

  /// The point halfway between two lit points of a smooth piece.
  Lit between(const Lit& a, const Lit& b) const {
    Lit middle{.along = 0.5 * (a.along + b.along), .between = true};
    Found found;
    if (!find(a, b, middle.along, found)) return middle;
    middle.depth = found.depth;
    middle.slope = -found.depth * glm::dot(found.normal, change()) /
                   glm::dot(found.normal, toward(middle.along));
    middle.position = found.position;
    middle.normal = found.normal;
    return middle;
  }

  void add_gap() {
    if (!lit_.empty() && lit_.back().lit()) lit_.emplace_back();
  }

  /// Whether the surface seems to continue from one point to the other.
  static bool connected(const Lit& a, const Lit& b) {
    const glm::dvec3 way = b.position - a.position;
    const double limit = 0.5 * std::sqrt(glm::dot(way, way));
    return std::abs(glm::dot(way, a.normal)) < limit && std::abs(glm::dot(way, b.normal)) < limit &&
           glm::dot(a.normal, b.normal) > 0.3;
  }

  /// A point of the curve as a camera sees it.
  struct Sight {
    bool visible = false;
    double row = 0.0;   ///< the row, or the column, of the camera that it appears in
    double near = 0.0;  ///< there is no surface nearer to the camera in this direction
  };

  /// The sight of a point, visible unless the surface hides it.
  Sight unhidden_sight(std::size_t number, const glm::dvec3& p, const glm::dvec3& normal) const {
    const Pinhole& camera = scene_.rig.cameras[number];
    const double half = scene_.options.rig.half_field;
    const glm::dvec3 seen = camera.project(p);
    if (!(seen.z > 0.0 && std::abs(seen.x) < half && std::abs(seen.y) < half)) return {};
    const glm::dvec3 way = p - camera.position;
    const DepthRange& range = scene_.camera_ranges[number];
    return {-glm::dot(normal, way) >= scene_.options.least_cosine * std::sqrt(glm::dot(way, way)),
            (family_ == 0 ? seen.y : seen.x) * scene_.distance / scene_.options.pixel,
            range.at(range.tile_of(seen.x), range.tile_of(seen.y)).near};
  }

  /// Whether the surface hides one of its points from a camera. The ray starts at the point, so
  /// that it passes most of the blends near the point at once.
  bool hidden(std::size_t number, const glm::dvec3& p, double near) const {
    const glm::dvec3 way = scene_.rig.cameras[number].position - p;
    const double length = std::sqrt(glm::dot(way, way));
    return hits_anything(scene_.grid, {p, way / length}, 1e-5, length - near);
  }

  Sight sight(std::size_t number, const glm::dvec3& p, const glm::dvec3& normal) const {
    Sight sight = unhidden_sight(number, p, normal);
    if (sight.visible) sight.visible = !hidden(number, p, sight.near);
    return sight;
  }

  /// Fills sights_ with a camera's sights of all lit points.
  void look(std::size_t number) {
    sights_.resize(lit_.size());
    for (std::size_t i = 0; i < lit_.size(); ++i) {
      if (!lit_[i].lit() || lit_[i].between) continue;
      sights_[i] = sight(number, lit_[i].position, lit_[i].normal);
    }
    for (std::size_t i = 0; i < lit_.size(); ++i) {
      if (!lit_[i].lit() || !lit_[i].between) continue;
      Sight& now = sights_[i];
      now = unhidden_sight(number, lit_[i].position, lit_[i].normal);
      if (sights_[i - 1].visible == sights_[i + 1].visible) {
        now.visible = now.visible && sights_[i - 1].visible;
      } else if (now.visible) {
        now.visible = !hidden(number, lit_[i].position, now.near);
      }
    }
  }

  /// The part of the interval from a to b that a camera sees, as shares of its length.
  struct Part {
    double begin = 0.0, end = 1.0;
  };

  /// To be called if the camera sees exactly one of the two ends.
  Part visible_part(std::size_t number, const Lit& a, const Lit& b, bool sees_a) const {
    double seen = sees_a ? 0.0 : 1.0, hidden = 1.0 - seen;
    for (int i = 0; i < kHidingHalvings; ++i) {
      const double middle = 0.5 * (seen + hidden);
      ScanPoint point;
      const bool visible = measure(number, a, b, a.along + middle * (b.along - a.along), point) &&
                           sight(number, point.truth, point.normal).visible;
      (visible ? seen : hidden) = middle;
    }
    return sees_a ? Part{0.0, seen} : Part{seen, 1.0};
  }

  void observe(std::size_t pair, std::vector<ScanPoint>& points) {
    const std::size_t camera = scene_.rig.pairs[pair].camera;
    Random random(scene_.frame_seed,
                  stream(ScanUse::curve, (pair * 2 + static_cast<std::size_t>(family_)) << 24 |
                                             (static_cast<std::uint64_t>(number_) & 0xffffff)));
    Detection detection{pair, random.bits(), random.uniform(), random.normal()};
    look(camera);
    Sight before;
    for (std::size_t i = 0; i < lit_.size(); ++i) {
      if (!lit_[i].lit()) continue;
      const Sight now = sights_[i];
      if (i > 0 && lit_[i - 1].lit() && (now.visible || before.visible)) {
        const Lit &a = lit_[i - 1], &b = lit_[i];
        const Part part =
            now.visible && before.visible ? Part{} : visible_part(camera, a, b, before.visible);
        const double low = std::min(now.row, before.row), high = std::max(now.row, before.row);
        const double begin = std::floor(low) + 1.0, end = std::floor(high);
        const auto count = static_cast<int>(end - begin) + 1;
        for (int k = 0; k < count; ++k) {
          const double row = now.row > before.row ? begin + k : end - k;
          const double share = (row - before.row) / (now.row - before.row);
          if (share < part.begin || share > part.end) continue;
          detect(a, b, a.along + share * (b.along - a.along), detection, random, points);
        }
      }
      before = now;
    }
  }

  /// The state of a pair that detects points along a curve.
  struct Detection {
    std::size_t pair;
    std::uint64_t pieces_seed;
    double first_piece;  ///< the place where the first piece begins
    double wander;       ///< the error that is correlated along the curve, with deviation 1
  };

  void detect(const Lit& a, const Lit& b, double along, Detection& detection, Random& random,
              std::vector<ScanPoint>& points) const {
    const ScanOptions& options = scene_.options;
    const double memory = options.noise_memory;
    detection.wander =
        memory * detection.wander + std::sqrt(1.0 - memory * memory) * quick_normal(random);
    const double piece =
        std::floor(along * scene_.distance / options.piece + detection.first_piece);
    const double luck =
        Random(detection.pieces_seed, static_cast<std::uint64_t>(static_cast<std::int64_t>(piece)))
            .uniform();
    if (luck < options.lost) return;
    const std::size_t camera = scene_.rig.pairs[detection.pair].camera;
    ScanPoint point;
    if (!measure(camera, a, b, along, point)) return;
    if (lost_in_patch(point.truth)) return;
    const double chance = (luck - options.lost) / (1.0 - options.lost);
    point.color = color_at(scene_.body, point.primitive, point.truth);
    if (chance < options.lost_dark && luminance(point.color) < options.dark) return;
    point.pair = static_cast<std::uint16_t>(detection.pair);
    disturb(scene_.rig.cameras[camera], detection.wander, random, point);
    points.push_back(point);
  }

  /// A point of the surface on the curve.
  struct Found {
    double depth;
    glm::dvec3 position, normal;
    std::uint16_t primitive;
  };

  /// Finds the point of the surface at `along` between two lit points; false if there is none or
  /// the projector lights it at too flat an angle.
  bool find(const Lit& a, const Lit& b, double along, Found& found) const {
    const double h = b.along - a.along;
    const double s = (along - a.along) / h;
    // The cubic with the depths and slopes of both ends.
    const double rise = b.depth - a.depth;
    const double c2 = 3.0 * rise - h * (2.0 * a.slope + b.slope);
    const double c3 = h * (a.slope + b.slope) - 2.0 * rise;
    const double depth = a.depth + s * (h * a.slope + s * (c2 + s * c3));
    const glm::dvec3 way = toward(along);
    const auto hit = hit_near(scene_.grid, view_.position, way, depth);
    if (!hit) return false;
    const double square = glm::dot(hit->gradient, hit->gradient);
    found = {hit->depth, hit->position, hit->gradient / std::sqrt(square), hit->primitive};
    return -glm::dot(hit->gradient, way) >
           scene_.options.least_cosine * std::sqrt(square * glm::dot(way, way));
  }

  /// Finds the point of the surface at `along` for a camera; false if there is none or the
  /// projector or the camera sees it at too flat an angle.
  bool measure(std::size_t camera, const Lit& a, const Lit& b, double along,
               ScanPoint& point) const {
    Found found;
    if (!find(a, b, along, found)) return false;
    point.truth = found.position;
    point.normal = found.normal;
    point.primitive = found.primitive;
    point.family = static_cast<std::uint16_t>(family_);
    point.curve = number_;
    const glm::dvec3 back = scene_.rig.cameras[camera].position - point.truth;
    return glm::dot(point.normal, back) >
           scene_.options.least_cosine * std::sqrt(glm::dot(back, back));
  }

  bool lost_in_patch(const glm::dvec3& p) const {
    for (const Patch& patch : scene_.patches) {
      if (!patch.around.holds(p)) continue;
      for (const Ball& ball : patch.balls) {
        if (ball.holds(p)) return true;
      }
    }
    return false;
  }

  void disturb(const Pinhole& camera, double wander, Random& random, ScanPoint& point) const {
    const ScanOptions& options = scene_.options;
    const glm::dvec3 way = point.truth - camera.position;
    const double distance = std::sqrt(glm::dot(way, way));
    const glm::dvec3 ray = way / distance;
    const double cosine = std::max(-glm::dot(point.normal, ray), options.least_cosine);
    const double far = distance / scene_.distance;
    const double mixed = std::sqrt(options.noise_correlated) * wander +
                         std::sqrt(1.0 - options.noise_correlated) * quick_normal(random);
    double offset = options.noise * far * far / cosine * mixed;
    if (random.uniform() < options.outliers) {
      const double u = 2.0 * random.uniform() - 1.0;
      offset += options.outlier_reach * u * u * u;
      point.outlier = true;
    }
    point.position = scene_.calibrations[point.pair].apply(point.truth + offset * ray);
  }

  const Scene& scene_;
  const Pinhole& view_;
  const DepthRange& range_;
  std::size_t projector_;
  int family_;
  std::int32_t number_;
  double across_;  ///< the coordinate in the projector's picture that is constant along the curve
  std::vector<Lit> lit_;
  std::vector<Sight> sights_;  ///< of the current camera, one for each of lit_
};

Result<void> check(const ScanOptions& options) {
  const auto share = [](double x) { return x >= 0.0 && x <= 1.0; };
  if (!(options.rig.projectors >= 2 && options.rig.projectors <= 100 && options.rig.radius > 0.0 &&
        options.rig.half_field > 0.0 && options.rig.half_field <= 5.0)) {
    return fail(ErrorCode::argument,
                "a scanner needs 2 to 100 projectors, a radius above 0 and a field of view "
                "from 0 to 5");
  }
  if (!(options.curve_spacing > 0.0 && options.pixel >= 1e-5)) {
    return fail(ErrorCode::argument,
                "a scanner needs a curve spacing above 0 and a pixel of at least 0.01 mm");
  }
  if (!(options.least_cosine > 0.0 && options.least_cosine < 1.0 && options.noise >= 0.0 &&
        options.piece > 0.0 && share(options.noise_correlated) && share(options.noise_memory) &&
        share(options.outliers) && share(options.lost) && share(options.lost_dark) &&
        options.outlier_reach >= 0.0 && options.patches >= 0 && options.patch_radius >= 0.0)) {
    return fail(ErrorCode::argument, "the scanner's noise, cosine or shares are out of range");
  }
  return {};
}

std::vector<Patch> place_patches(const SurfaceGrid& grid, const ScanOptions& options,
                                 std::uint64_t seed) {
  std::vector<Patch> patches;
  Random random(seed, stream(ScanUse::patches, 0));
  for (int i = 0; i < options.patches; ++i) {
    const auto& cell = grid.cells()[random.below(static_cast<std::uint32_t>(grid.cells().size()))];
    const double radius = options.patch_radius * random.uniform();
    const glm::dvec3 center = cell.min + 0.5 * SurfaceGrid::kCell;
    // The centres of the balls are at most 0.6 of this radius away on each axis, and their radii
    // are below 0.8 of it.
    Patch& patch = patches.emplace_back();
    patch.around = {center, 1.85 * radius};
    for (Ball& ball : patch.balls) {
      const double x = random.uniform(), y = random.uniform(), z = random.uniform();
      const double share = 0.4 + 0.4 * random.uniform();
      ball = {center + radius * (1.2 * glm::dvec3(x, y, z) - 0.6), share * radius};
    }
  }
  return patches;
}

std::vector<Calibration> calibrate(std::size_t pairs, const ScanOptions& options,
                                   std::uint64_t seed) {
  std::vector<Calibration> calibrations(pairs);
  for (std::size_t i = 0; i < pairs; ++i) {
    calibrations[i] = random_calibration(Random(seed, stream(ScanUse::calibration, i)),
                                         options.calibration_shift, options.calibration_turn);
  }
  return calibrations;
}

}  // namespace

Result<std::vector<ScanPoint>> scan(const Body& body, const ScanOptions& options,
                                    std::uint64_t seed, int frame) {
  TRY(check(options));
  const auto grid = TRY(SurfaceGrid::build(body.surface));
  if (grid.cells().empty()) {
    return fail(ErrorCode::argument, "cannot sample a surface that has no area");
  }

  const std::uint64_t frame_seed =
      Random(seed, static_cast<std::uint64_t>(static_cast<std::int64_t>(frame))).bits();
  Scene scene{body,
              grid,
              options,
              make_rig(options.rig),
              working_distance(options.rig),
              {},
              {},
              {},
              place_patches(grid, options, frame_seed),
              frame_seed};
  scene.calibrations = calibrate(scene.rig.pairs.size(), options, seed);
  const std::size_t count = scene.rig.projectors.size();
  std::vector<std::optional<DepthRange>> ranges(2 * count);
  tbb::parallel_for(std::size_t{0}, 2 * count, [&](std::size_t i) {
    const Pinhole& view = i < count ? scene.rig.projectors[i] : scene.rig.cameras[i - count];
    ranges[i].emplace(grid, view, options.rig.half_field);
  });
  for (std::size_t i = 0; i < count; ++i) {
    scene.projector_ranges.push_back(std::move(*ranges[i]));
    scene.camera_ranges.push_back(std::move(*ranges[count + i]));
  }

  std::vector<std::vector<ScanPoint>> found(2 * count);
  tbb::parallel_for(std::size_t{0}, 2 * count, [&](std::size_t i) {
    const std::size_t projector = i / 2;
    const int family = static_cast<int>(i % 2);
    const double spacing = options.curve_spacing / scene.distance;
    // The pattern has a new phase in every frame.
    const double phase = Random(frame_seed, stream(ScanUse::phase, i)).uniform();
    const double half = options.rig.half_field;
    const auto first = static_cast<std::int32_t>(std::floor(-half / spacing - phase)) + 1;
    for (std::int32_t number = first; (number + phase) * spacing < half; ++number) {
      Curve(scene, projector, family, number, (number + phase) * spacing).trace(found[i]);
    }
  });
  std::size_t total = 0;
  for (const auto& some : found) total += some.size();
  std::vector<ScanPoint> points;
  points.reserve(total);
  for (const auto& some : found) points.insert(points.end(), some.begin(), some.end());
  return points;
}

}  // namespace pointreel
