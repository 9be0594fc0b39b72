#include "client/scene/divided_patch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>

#include "codec/surface/lanes.h"
#include "pointreel/cpu.h"

namespace pointreel {
namespace {

/// Colours are blended within so many spacings between surfels around the one that is divided, and
/// so many times the distance to the nearest surfel: surfels may be dense along curves with gaps
/// between them, and then their radii are much larger than the detail in their colours.
constexpr float kColorSpacings = 1.8f, kColorReach = 1.4f;
constexpr std::size_t kSpacingNeighbors = 8;
/// At least this share of the radius within which spheres are blended: neighbours may coincide.
constexpr float kLeastColorReach = 0.05f;
/// Less than 1, so that neighbours overlap a little.
constexpr float kOverlap = 0.9f;

/// Eight vectors.
struct Vectors {
  Lanes x, y, z;
};

/// What eight places become.
struct Surfels {
  Vectors position, normal, color;
  LaneMask found;
};

#define POINTREEL_INLINE [[gnu::always_inline]] inline

POINTREEL_INLINE bool any(const LaneMask& mask) {
  std::int32_t all = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) all |= mask[lane];
  return all != 0;
}

/// Of those lanes that count.
POINTREEL_INLINE float greatest(const Lanes& values, const LaneMask& counts) {
  float most = 0.0f;
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    if (counts[lane] != 0) most = std::max(most, values[lane]);
  return most;
}

POINTREEL_INLINE void weigh(const Lanes& squares, const Lanes& reach_square, Lanes& weight) {
  const Lanes left = 1.0f - squares / reach_square;
  const Lanes squared = left * left;
  weight = left > 0.0f ? squared * squared : Lanes{};
}

/// Places above or below a sphere.
struct Feet {
  Lanes height;    ///< of the places above the sphere, along the patch's normal
  Vectors normal;  ///< of the sphere below them
};

/// `way`: from the patch to the places.
POINTREEL_INLINE Feet feet_of(const Blended& patch, const Vectors& way) {
  const glm::vec3& n = patch.normal;
  const float curvature = patch.curvature;
  const Lanes up = way.x * n.x + way.y * n.y + way.z * n.z;
  const Vectors along{way.x - up * n.x, way.y - up * n.y, way.z - up * n.z};
  const Lanes square = along.x * along.x + along.y * along.y + along.z * along.z;
  const Lanes left = 1.0f - curvature * curvature * square;
  Lanes cosine = left > 0.0f ? left : Lanes{};
  take_roots(cosine);
  return {up + curvature * square / (1.0f + cosine),
          {cosine * n.x + curvature * along.x, cosine * n.y + curvature * along.y,
           cosine * n.z + curvature * along.z}};
}

/// The places, at these offsets from the middle of a patch, where it has the surface. `wanted`:
/// which of them count. `others`: by their distance from the patch.
struct Question {
  const Blended& own;
  std::span<const Blended> others;
  float widest, spacing;
  Vectors offset;
  LaneMask wanted;
};

POINTREEL_INLINE void answer(const Question& asked, Surfels& surfels) {
  const Blended& own = asked.own;
  const Vectors& offset = asked.offset;
  surfels.found = LaneMask{};
  const Lanes square = offset.x * offset.x + offset.y * offset.y + offset.z * offset.z;
  Lanes length = square;
  take_roots(length);
  // On the patch's own sphere, so that what is near is judged where the surface is.
  const Feet foot = feet_of(own, offset);
  const Vectors from_own{offset.x - foot.height * own.normal.x,
                         offset.y - foot.height * own.normal.y,
                         offset.z - foot.height * own.normal.z};
  const Vectors place{own.position.x + from_own.x, own.position.y + from_own.y,
                      own.position.z + from_own.z};
  Lanes far = from_own.x * from_own.x + from_own.y * from_own.y + from_own.z * from_own.z;
  take_roots(far);
  const Lanes near_square = kOverlap * kOverlap * square;
  LaneMask mine = asked.wanted;
  const float nearest = greatest(far + kOverlap * length, mine);
  for (const Blended& other : asked.others) {
    if (other.far > nearest) break;
    const Lanes x = place.x - other.position.x, y = place.y - other.position.y,
                z = place.z - other.position.z;
    mine &= ~(x * x + y * y + z * z < near_square);
    if (!any(mine)) return;
  }
  const Lanes around = kColorSpacings * asked.spacing + kColorReach * length;
  const float least = kLeastColorReach * own.reach;
  const Lanes color_reach = around > least ? around : Lanes{} + least;
  const Lanes color_square = color_reach * color_reach,
              own_square = Lanes{} + own.reach * own.reach;
  Lanes total, color_total, height{};
  weigh(square, own_square, total);
  weigh(square, color_square, color_total);
  Vectors normal{total * foot.normal.x, total * foot.normal.y, total * foot.normal.z};
  Vectors color{color_total * own.color.x, color_total * own.color.y, color_total * own.color.z};
  const float last = greatest(far, mine) + asked.widest;
  for (const Blended& other : asked.others) {
    if (other.far > last) break;
    const Vectors way{place.x - other.position.x, place.y - other.position.y,
                      place.z - other.position.z};
    const Lanes its_square = way.x * way.x + way.y * way.y + way.z * way.z;
    Lanes weight, color_weight;
    weigh(its_square, Lanes{} + other.reach * other.reach, weight);
    if (!any((weight > 0.0f) & mine)) continue;
    const Feet its = feet_of(other, way);
    total += weight;
    height += weight * other.cosine * its.height;
    normal.x += weight * its.normal.x;
    normal.y += weight * its.normal.y;
    normal.z += weight * its.normal.z;
    weigh(its_square, color_square, color_weight);
    color_weight = weight > 0.0f ? color_weight : Lanes{};
    color_total += color_weight;
    color.x += color_weight * other.color.x;
    color.y += color_weight * other.color.y;
    color.z += color_weight * other.color.z;
  }
  surfels.found = mine & (total > 0.0f);
  const Lanes divisor = surfels.found ? total : Lanes{} + 1.0f;
  const Lanes down = height / divisor;
  surfels.position = {place.x - down * own.normal.x, place.y - down * own.normal.y,
                      place.z - down * own.normal.z};
  const Lanes squared = normal.x * normal.x + normal.y * normal.y + normal.z * normal.z;
  Lanes slope = squared > 0.0f ? squared : Lanes{} + 1.0f;
  take_roots(slope);
  surfels.normal = {normal.x / slope, normal.y / slope, normal.z / slope};
  const Lanes per_color = 1.0f / (color_total > 0.0f ? color_total : Lanes{} + 1.0f);
  surfels.color = {color.x * per_color, color.y * per_color, color.z * per_color};
}

// The variants give the same to the bit, because the lanes are the same and nothing is contracted.
void answer_portable(const Question& asked, Surfels& surfels) { answer(asked, surfels); }
#if defined(__x86_64__)
[[gnu::target("avx2")]] void answer_avx2(const Question& asked, Surfels& surfels) {
  answer(asked, surfels);
}
auto best_answer() { return (cpu_features() & kCpuAvx2) != 0 ? answer_avx2 : answer_portable; }
#else
auto best_answer() { return answer_portable; }
#endif

}  // namespace

void DividedPatch::finish() {
  const std::span others = std::span(others_).first(count_);
  std::ranges::sort(others, {}, &Blended::far);
  const std::size_t last = std::min(kSpacingNeighbors, count_);
  if (last > 0)
    spacing_ =
        others[last - 1].far * std::sqrt(std::numbers::pi_v<float> / static_cast<float>(last + 1));
}

void DividedPatch::divide(float reach, float step, std::vector<RefinedSurfel>& surfels) const {
  const glm::vec3 n = own_.normal;
  const glm::vec3 across =
      glm::normalize(glm::cross(n, std::abs(n.x) < 0.6f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0)));
  const glm::vec3 along = glm::cross(n, across);
  const int rows = static_cast<int>(reach / step);
  const auto answer_here = best_answer();
  Surfels found;
  for (int y = -rows; y <= rows; ++y) {
    const float v = step * static_cast<float>(y);
    const int last = static_cast<int>(std::sqrt(std::max(0.0f, reach * reach - v * v)) / step);
    for (int begin = -last; begin <= last; begin += static_cast<int>(kLanes)) {
      Lanes u{};
      LaneMask wanted{};
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const int x = begin + static_cast<int>(lane);
        u[lane] = step * static_cast<float>(x);
        wanted[lane] = x <= last ? -1 : 0;
      }
      answer_here({own_, std::span(others_).first(count_), widest_, spacing_,
                   Vectors{u * across.x + v * along.x, u * across.y + v * along.y,
                           u * across.z + v * along.z},
                   wanted},
                  found);
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        if (found.found[lane] == 0) continue;
        const auto vector = [lane](const Vectors& of) {
          return glm::vec3(of.x[lane], of.y[lane], of.z[lane]);
        };
        surfels.push_back({vector(found.position), 0.0f, 0.0f, vector(found.normal),
                           glm::u16vec3(glm::clamp(vector(found.color) + 0.5f, 0.0f, 65535.0f))});
      }
    }
  }
}

}  // namespace pointreel
