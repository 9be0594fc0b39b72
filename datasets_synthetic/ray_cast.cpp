#include "datasets_synthetic/ray_cast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

// The distance to a convex primitive is a convex function: along a ray it lies above its tangents
// and, between two points, below its chord. The smooth union grows with both of its arguments, so
// the smooth union of two straight lines bounds it from below (tangents) or from above (chords),
// and
// the root of such a bound has a closed form. Outside, a step to the root of the bound by tangents
// never passes the surface, and it is short, like Newton's, only near the surface. Inside, the
// bound
// by chords does the same for the way out. So nothing is skipped, not even at grazing angles or in
// creases.

namespace pointreel {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
/// Distances in metres at which a ray counts as having reached the surface from outside, and as
/// having left it. They differ, so that a ray that only touches the surface enters and leaves once.
constexpr double kReached = 2e-10;
constexpr double kLeft = 4e-10;
constexpr int kMaxSteps = 200;  // in one cell; usually it takes a handful

/// The place where the line is zero.
double root(const RayLine& line) { return line.slope != 0.0 ? -line.value / line.slope : kNever; }

double union_at(const RayLine& a, const RayLine& b, double blend, double s) {
  const double x = a.at(s), y = b.at(s);
  const double overlap = blend - std::abs(x - y);
  return std::min(x, y) - (overlap > 0.0 ? 0.25 * overlap * overlap / blend : 0.0);
}

/// The smallest s > 0 at which the smooth union of two lines is zero; kNever if there is none.
double root_of_union(const RayLine& a, const RayLine& b, double blend) {
  double first = kNever;
  constexpr double kSlack = 1e-9;  // lets the pieces overlap a little where they meet
  const auto consider_line = [&](const RayLine& line, const RayLine& other) {
    const double s = root(line);
    if (s > 0.0 && s < first && other.at(s) >= blend * (1.0 - kSlack)) first = s;
  };
  consider_line(a, b);
  consider_line(b, a);
  if (!(blend > 0.0)) return first;
  // With d = a - b and |d| < blend, the union is (a + b) / 2 - (blend^2 + d^2) / (4 blend).
  const RayLine d{a.value - b.value, a.slope - b.slope};
  const double per = 0.25 / blend;
  const double c0 = 0.5 * (a.value + b.value) - 0.25 * blend - per * d.value * d.value;
  const double c1 = 0.5 * (a.slope + b.slope) - 2.0 * per * d.value * d.slope;
  const double c2 = -per * d.slope * d.slope;
  const double discriminant = c1 * c1 - 4.0 * c2 * c0;
  if (!(discriminant >= 0.0)) return first;
  const double q = -0.5 * (c1 + (c1 >= 0.0 ? 1.0 : -1.0) * std::sqrt(discriminant));
  const auto consider = [&](double s) {
    if (s > 0.0 && s < first && std::abs(d.at(s)) <= blend * (1.0 + kSlack)) first = s;
  };
  if (q != 0.0) consider(c0 / q);
  if (c2 != 0.0) consider(q / c2);
  return first;
}

/// The blends that a ray has passed: the distances of both primitives grow along it and, being
/// convex, keep growing.
class LeftBehind {
 public:
  bool holds(std::uint16_t blend) const {
    return blend < kMost && (bits_[blend / 64] >> (blend % 64) & 1u) != 0;
  }
  void add(std::uint16_t blend) {
    if (blend < kMost) bits_[blend / 64] |= std::uint64_t{1} << (blend % 64);
  }

 private:
  static constexpr std::size_t kMost = 512;  // blends with a higher number are examined again
  std::array<std::uint64_t, kMost / 64> bits_{};
};

/// The blends that matter to a ray in one cell.
class CellRay {
 public:
  /// Selects the cell's blends that come within `furthest` of its centre and that the ray has not
  /// passed.
  CellRay(const SurfaceGrid& grid, const SurfaceGrid::Cell& cell, const Ray& ray, double furthest,
          const LeftBehind& behind)
      : grid_(grid), cell_(cell), ray_(ray), all_(grid.blends(cell)) {
    const std::span<const float> values = grid.blend_values(cell);
    for (std::size_t i = 0; i < all_.size(); ++i) {
      if (values[i] > furthest) {
        left_out_ = values[i];  // all that follow are further away
        break;
      }
      if (behind.holds(all_[i])) continue;
      const Blend& blend = grid.surface().blends[all_[i]];
      const std::uint8_t first = place_of(blend.first);
      // A primitive that stands alone is stored as a blend with itself, but without a fillet.
      const bool alone = blend.first == blend.second;
      blends_[blend_count_++] = {first, alone ? first : place_of(blend.second), all_[i],
                                 alone ? 0.0 : blend.radius};
    }
  }

  bool empty() const { return blend_count_ == 0; }

  /// The least distance from the centre to a blend that is neither selected nor passed.
  double left_out() const { return left_out_; }

  /// Moves to t, takes the tangents there and returns the distance.
  double move_to(double t) {
    const glm::dvec3 p = ray_.at(t);
    for (std::size_t i = 0; i < count_; ++i) {
      lines_[i] = grid_.ray_primitives()[primitives_[i]].along(p, ray_.direction);
    }
    double distance = kNever;
    for (std::size_t i = 0; i < blend_count_; ++i) {
      values_[i] = with_lines(lines_, i, [](const RayLine& a, const RayLine& b, double blend) {
        return union_at(a, b, blend, 0.0);
      });
      distance = std::min(distance, values_[i]);
    }
    return distance;
  }

  /// To be called after move_to. Drops the blends that the ray cannot reach within `length` and
  /// those that it has passed; returns false if none remain. `nearest` becomes the least distance
  /// to a blend that the ray has not passed.
  bool keep_near(double length, LeftBehind& behind, double& nearest) {
    nearest = kNever;
    std::size_t kept = 0;
    std::uint64_t used = 0;
    for (std::size_t i = 0; i < blend_count_; ++i) {
      if (values_[i] > kLeft && lines_[blends_[i].first].slope >= 0.0 &&
          lines_[blends_[i].second].slope >= 0.0) {
        behind.add(blends_[i].number);
        continue;
      }
      nearest = std::min(nearest, values_[i]);
      if (values_[i] > length + kLeft) continue;
      blends_[kept++] = blends_[i];
      used |= std::uint64_t{1} << blends_[i].first | std::uint64_t{1} << blends_[i].second;
    }
    if (kept == blend_count_) return true;
    blend_count_ = kept;
    std::array<std::uint8_t, kMaxPrimitives> places;
    std::size_t count = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if ((used >> i & 1u) == 0) continue;
      places[i] = static_cast<std::uint8_t>(count);
      primitives_[count] = primitives_[i];
      lines_[count++] = lines_[i];
    }
    count_ = count;
    for (std::size_t i = 0; i < kept; ++i) {
      blends_[i].first = places[blends_[i].first];
      blends_[i].second = places[blends_[i].second];
    }
    return kept > 0;
  }

  /// For a place outside: a step, from the tangents, that does not pass the surface.
  double step_outside() const {
    double step = kNever;
    for (std::size_t i = 0; i < blend_count_; ++i) {
      step = std::min(step, with_lines(lines_, i, root_of_union));
    }
    return step;
  }

  /// To be called after move_to(t): a step over which the distance stays below `level`; kNever if
  /// it does so up to `end`.
  double step_inside(double t, double end, double level) const {
    const glm::dvec3 p = ray_.at(end);
    Lines chords;
    for (std::size_t i = 0; i < count_; ++i) {
      const double value = grid_.ray_primitives()[primitives_[i]].along(p, ray_.direction).value;
      chords[i] = {lines_[i].value - level, (value - lines_[i].value) / (end - t)};
    }
    // Each bound is a concave function: once it has risen above zero and fallen again, it stays
    // below zero. So the step ends where the last bound rises above zero, unless another has fallen
    // below zero by then.
    double step = 0.0;
    for (std::size_t i = 0; i < blend_count_; ++i) {
      if (values_[i] < level) step = std::max(step, with_lines(chords, i, root_of_union));
    }
    if (!(step < end - t)) return kNever;
    for (std::size_t i = 0; i < blend_count_; ++i) {
      const double value =
          with_lines(chords, i, [step](const RayLine& a, const RayLine& b, double blend) {
            return union_at(a, b, blend, step);
          });
      if (value < -1e-12) return kNever;
    }
    return step;
  }

  RayHit hit(double t, bool enters) const {
    const glm::dvec3 p = ray_.at(t);
    const SurfaceDistance at = grid_.distance(cell_, p);
    const double square = glm::dot(at.distance.gradient, at.distance.gradient);
    const glm::dvec3 normal = square > 1e-12 ? at.distance.gradient / std::sqrt(square)
                                             : (enters ? -1.0 : 1.0) * ray_.direction;
    return {t, p, normal, at.primitive, enters};
  }

 private:
  static constexpr std::size_t kMaxPrimitives = 2 * SurfaceGrid::kMaxBlends;
  using Lines = std::array<RayLine, kMaxPrimitives>;
  struct NearBlend {
    std::uint8_t first, second;  // indices in primitives_; equal for a primitive that stands alone
    std::uint16_t number;        // index among the blends of the surface
    double radius;
  };

  std::uint8_t place_of(std::uint16_t primitive) {
    std::size_t i = 0;
    while (i < count_ && primitives_[i] != primitive) ++i;
    if (i == count_) primitives_[count_++] = primitive;
    return static_cast<std::uint8_t>(i);
  }

  template <class Function>
  double with_lines(const Lines& lines, std::size_t i, const Function& function) const {
    const NearBlend& blend = blends_[i];
    return function(lines[blend.first],
                    blend.first == blend.second ? RayLine{kNever, 0.0} : lines[blend.second],
                    blend.radius);
  }

  const SurfaceGrid& grid_;
  const SurfaceGrid::Cell& cell_;
  const Ray& ray_;
  std::span<const std::uint16_t> all_;
  std::size_t blend_count_ = 0, count_ = 0;
  double left_out_ = SurfaceGrid::kListed;
  std::array<NearBlend, SurfaceGrid::kMaxBlends> blends_;
  std::array<double, SurfaceGrid::kMaxBlends> values_;  // the distances of the blends
  std::array<std::uint16_t, kMaxPrimitives> primitives_;
  Lines lines_;
};
static_assert(2 * SurfaceGrid::kMaxBlends <= 64, "keep_near stores a set of primitives in 64 bits");

/// Follows a ray from cell to cell and keeps track of the side of the surface that it is on.
class Caster {
 public:
  Caster(const SurfaceGrid& grid, const Ray& ray) : grid_(grid), ray_(ray) {}

  /// Calls found(cell ray, t, enters) for each hit; it returns whether to go on.
  template <class Found>
  void cast(double from, double to, const Found& found) {
    const glm::dvec3 inverse = 1.0 / ray_.direction;
    const glm::dvec3 box = SurfaceGrid::kCell * glm::dvec3(grid_.size());
    for (int axis = 0; axis < 3; ++axis) {
      const double low = grid_.origin()[axis] - ray_.origin[axis];
      if (ray_.direction[axis] == 0.0) {
        if (low > 0.0 || low + box[axis] < 0.0) return;
        continue;
      }
      const double a = low * inverse[axis], b = (low + box[axis]) * inverse[axis];
      from = std::max(from, std::min(a, b));
      to = std::min(to, std::max(a, b));
    }
    if (!(from < to)) return;
    const glm::ivec3 limit = grid_.size() - 1;
    glm::ivec3 cell = glm::clamp(grid_.cell_at(ray_.at(from)), glm::ivec3(0), limit);
    // The ray reaches the plane between the cells i - 1 and i of an axis at start + i * step.
    const glm::dvec3 start = (grid_.origin() - ray_.origin) * inverse;
    const glm::dvec3 step = SurfaceGrid::kCell * inverse;
    const auto plane_at = [&](int axis, int plane) {
      return ray_.direction[axis] != 0.0 ? start[axis] + step[axis] * plane : kNever;
    };
    const glm::ivec3 onward(ray_.direction.x > 0.0, ray_.direction.y > 0.0, ray_.direction.z > 0.0);
    double t = from;
    while (t < to) {
      const bool occupied = grid_.block_occupied(cell);
      // Go on to the nearest plane ahead: of the cell, or of the whole block if that is empty.
      const int edge = occupied ? 1 : SurfaceGrid::kBlock;
      const glm::ivec3 first(cell.x & -edge, cell.y & -edge, cell.z & -edge);
      const double x = plane_at(0, first.x + edge * onward.x);
      const double y = plane_at(1, first.y + edge * onward.y);
      const double z = plane_at(2, first.z + edge * onward.z);
      const int axis = x <= y ? (x <= z ? 0 : 2) : (y <= z ? 1 : 2);
      const double out = std::max(std::min(x, std::min(y, z)), t);
      if (occupied) {
        const std::uint32_t number = grid_.find(cell);
        if (number != SurfaceGrid::kNone &&
            !visit(grid_.cells()[number], t, std::min(out, to), found)) {
          return;
        }
      } else {
        cell = glm::clamp(grid_.cell_at(ray_.at(out)), first, first + edge - 1);
      }
      t = out;
      cell[axis] = onward[axis] != 0 ? first[axis] + edge : first[axis] - 1;
      if (cell[axis] < 0 || cell[axis] > limit[axis]) return;
    }
  }

 private:
  template <class Found>
  bool visit(const SurfaceGrid::Cell& cell, double t, double out, const Found& found) {
    // No point of the surface is nearer to the centre than |cell.distance|.
    const glm::dvec3 center = cell.min + 0.5 * SurfaceGrid::kCell;
    const glm::dvec3 enter = ray_.at(t) - center, leave = ray_.at(out) - center;
    const double furthest = std::max(glm::dot(enter, enter), glm::dot(leave, leave));
    if (furthest < cell.distance * cell.distance) {
      if (side_ == Side::unknown) side_ = cell.distance < 0.0 ? Side::inside : Side::outside;
      return true;
    }
    if (side_ != Side::unknown) t = std::max(t, clear_until_);
    if (t >= out) return true;
    // The micrometre makes up for the single precision of the distances that this is compared with.
    CellRay along(grid_, cell, ray_, std::sqrt(furthest) + 1e-6, behind_);
    if (along.empty()) return true;  // the ray has passed all of them
    double end = out;
    for (int step = 0; step < kMaxSteps; ++step) {
      const double distance = along.move_to(t);
      if (side_ == Side::unknown) side_ = distance < 0.0 ? Side::inside : Side::outside;
      if (step == 0) {
        const glm::dvec3 off = ray_.at(t) - center;
        const double others = along.left_out() - std::sqrt(glm::dot(off, off)) - 1e-6;
        double nearest = std::abs(distance);
        const bool any = side_ != Side::outside || along.keep_near(out - t, behind_, nearest);
        clear_until_ = t + std::min(nearest, others);  // also beyond this cell
        if (!any) return true;
      }
      if (side_ == Side::outside) {
        if (distance <= kReached) {
          side_ = Side::inside;
          if (!found(along, t, true)) return false;
          end = out;
        } else {
          t += along.step_outside();
          if (!(t <= out)) return true;
          continue;
        }
      }
      if (distance >= 0.5 * (kReached + kLeft)) {
        side_ = Side::outside;
        if (!found(along, t, false)) return false;
        continue;
      }
      // Nothing can be found within less than 1e-12 m.
      const double s = end - t > 1e-12 ? along.step_inside(t, end, kLeft) : kNever;
      if (s == kNever) {
        t = end;
        if (!(t < out)) return true;
        end = out;
      } else {
        t += s;
        end = t + 0.5 * (end - t);  // shorter chords give tighter bounds
      }
    }
    return true;
  }

  enum class Side { unknown, outside, inside };

  const SurfaceGrid& grid_;
  const Ray& ray_;
  Side side_ = Side::unknown;
  double clear_until_ = 0.0;  ///< there is no surface before this t
  LeftBehind behind_;
};

}  // namespace

std::optional<RayHit> first_hit(const SurfaceGrid& grid, const Ray& ray, double from, double to) {
  std::optional<RayHit> first;
  Caster(grid, ray).cast(from, to, [&](const CellRay& along, double t, bool enters) {
    first = along.hit(t, enters);
    return false;
  });
  return first;
}

std::optional<NearHit> hit_near(const SurfaceGrid& grid, const glm::dvec3& origin,
                                const glm::dvec3& way, double depth) {
  for (int step = 0; step < 5; ++step) {
    const glm::dvec3 p = origin + depth * way;
    const glm::ivec3 cell = grid.cell_at(p);
    if (glm::any(glm::lessThan(cell, glm::ivec3(0))) ||
        glm::any(glm::greaterThanEqual(cell, grid.size()))) {
      return std::nullopt;
    }
    const std::uint32_t number = grid.find(cell);
    if (number == SurfaceGrid::kNone) return std::nullopt;
    const SurfaceDistance at = grid.distance(grid.cells()[number], p);
    const double slope = glm::dot(at.distance.gradient, way);
    if (!(slope < -1e-3)) return std::nullopt;
    const double move = -at.distance.value / slope;
    depth += move;
    // The remaining error is about the curvature times the square of the last move.
    if (std::abs(move) < 2e-5) {
      return NearHit{depth, origin + depth * way, at.distance.gradient, at.primitive};
    }
  }
  return std::nullopt;
}

bool hits_anything(const SurfaceGrid& grid, const Ray& ray, double from, double to) {
  bool any = false;
  Caster(grid, ray).cast(from, to, [&](const CellRay&, double, bool) {
    any = true;
    return false;
  });
  return any;
}

void all_hits(const SurfaceGrid& grid, const Ray& ray, std::vector<RayHit>& hits, double from,
              double to) {
  hits.clear();
  Caster(grid, ray).cast(from, to, [&](const CellRay& along, double t, bool enters) {
    hits.push_back(along.hit(t, enters));
    return true;
  });
}

}  // namespace pointreel
