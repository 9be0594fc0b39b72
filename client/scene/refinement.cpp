#include "client/scene/refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/base/for_each.h"
#include "common/threads/tbb_executor.h"

namespace pointreel {
namespace {

/// Surfels whose radius looks larger than so many pixels are divided.
constexpr float kLargePixels = 4.0f;
/// How far new surfels are apart, in pixels, and what share of that their radius is. The error of
/// flat discs (section 4.1 of the paper) would allow wider steps away from the outline, but large
/// discs beside small ones stand out, and colours become patchy.
constexpr float kStepPixels = 1.6f, kRadiusOfStep = 0.8f;
/// No more than so many new surfels for one, in each direction.
constexpr float kMostSteps = 64.0f;
/// The most new surfels of a picture, about; beyond, they are further apart.
constexpr double kMostSurfels = 600'000.0;
/// The radius within which spheres are fitted, the distance to which new surfels belong to an old
/// one, and the radius within which spheres and colours are blended, all in radii of surfels. These
/// radii are about the distance between neighbours.
constexpr float kSupport = 3.0f, kOwnReach = 1.4f, kBlended = 1.8f;
/// Colours are blended within so many spacings between surfels around the one that is divided, and
/// so many times the distance to the nearest surfel: surfels may be dense along curves with gaps
/// between them, and then their radii are much larger than the detail in their colours.
constexpr float kColorSpacings = 1.8f, kColorReach = 1.4f;
constexpr std::size_t kSpacingNeighbors = 8;
/// At least this share of the radius within which spheres are blended: neighbours may coincide.
constexpr float kLeastColorReach = 0.05f;
/// Less than 1, so that neighbours overlap a little.
constexpr float kOverlap = 0.9f;
constexpr double kBeta = 0.8;
/// A sphere bends by no more than so much within the reach of a surfel: the sine of the angle. At
/// the edges of surfaces, smaller spheres would stand out as curls.
constexpr float kMostBend = 0.6f;
/// Surfels that face away further than this, as a cosine, are only seen as the insides of holes,
/// and their outlines must not stand out. For that, new surfels may be further apart by this
/// factor.
constexpr float kAway = -0.25f, kStepAway = 2.0f;
constexpr std::size_t kPerTask = 256;

/// What a patch contributes to the surfels around it.
struct Blended {
  glm::vec3 position, normal;
  float curvature;
  glm::vec3 color;
  float reach;   ///< of its weight
  float far;     ///< from the patch that is divided
  float cosine;  ///< between its normal and that of the patch that is divided
};

/// A place above or below a sphere.
struct Foot {
  float height;      ///< of the place above the sphere, along the patch's normal
  glm::vec3 normal;  ///< of the sphere below it
};

Foot foot_of(const Blended& patch, const glm::vec3& place) {
  const glm::vec3 way = place - patch.position;
  const float up = glm::dot(way, patch.normal);
  const glm::vec3 along = way - up * patch.normal;
  const float square = glm::dot(along, along);
  const float bend = patch.curvature * patch.curvature * square;
  const float cosine = std::sqrt(std::max(0.0f, 1.0f - bend));
  return {up + patch.curvature * square / (1.0f + cosine),
          cosine * patch.normal + patch.curvature * along};
}

float weight(float square, float radius) {
  const float left = std::max(0.0f, 1.0f - square / (radius * radius));
  return left * left * left * left;
}

/// A patch that is divided, and those around it.
class DividedPatch {
 public:
  explicit DividedPatch(const Blended& own) : own_(own) {}

  void add(const Blended& other) {
    others_[count_++] = other;
    widest_ = std::max(widest_, other.reach);
  }
  /// After the last was added. Sorts them, so that a place is compared only with those that may
  /// matter there.
  void finish() {
    const std::span others = std::span(others_).first(count_);
    std::ranges::sort(others, {}, &Blended::far);
    const std::size_t last = std::min(kSpacingNeighbors, count_);
    if (last > 0)
      spacing_ = others[last - 1].far *
                 std::sqrt(std::numbers::pi_v<float> / static_cast<float>(last + 1));
  }

  /// The surface at a place in the plane of the patch; nothing if another patch is nearer.
  /// `offset`: from the middle of the patch, at a right angle to its normal.
  std::optional<RefinedSurfel> surfel_at(const glm::vec3& offset) const {
    const float square = glm::dot(offset, offset), length = std::sqrt(square);
    // On the patch's own sphere, so that what is near is judged where the surface is.
    glm::vec3 place = own_.position + offset;
    const Foot foot = foot_of(own_, place);
    place -= foot.height * own_.normal;
    const float far = glm::distance(place, own_.position);
    const auto square_to = [&place](const Blended& other) {
      const glm::vec3 way = place - other.position;
      return glm::dot(way, way);
    };
    for (const Blended& other : within(far + kOverlap * length)) {
      if (square_to(other) < kOverlap * kOverlap * square) return std::nullopt;
    }
    const float color_reach =
        std::max(kColorSpacings * spacing_ + kColorReach * length, kLeastColorReach * own_.reach);
    float total = weight(square, own_.reach), height = 0.0f;
    float color_total = weight(square, color_reach);
    glm::vec3 normal = total * foot.normal, color = color_total * own_.color;
    for (const Blended& other : within(far + widest_)) {
      const float its_square = square_to(other);
      const float w = weight(its_square, other.reach);
      if (w == 0.0f) continue;
      const Foot its = foot_of(other, place);
      total += w;
      height += w * its.height * other.cosine;
      normal += w * its.normal;
      const float color_weight = weight(its_square, color_reach);
      color_total += color_weight;
      color += color_weight * other.color;
    }
    if (!(total > 0.0f)) return std::nullopt;
    return RefinedSurfel{place - height / total * own_.normal, 0.0f, 0.0f, glm::normalize(normal),
                         glm::u16vec3(glm::clamp(color / color_total + 0.5f, 0.0f, 65535.0f))};
  }

 private:
  /// The others that are no further from the patch.
  std::span<const Blended> within(float far) const {
    const std::span others = std::span(others_).first(count_);
    const auto end = std::ranges::upper_bound(others, far, {}, &Blended::far);
    return others.first(static_cast<std::size_t>(end - others.begin()));
  }

  Blended own_;
  std::array<Blended, SurfacePatch::kMostNeighbors> others_;
  std::size_t count_ = 0;
  float widest_ = 0.0f;   ///< reach of the others
  float spacing_ = 0.0f;  ///< between surfels here
};

/// The size of a pixel at a distance of 1.
float pixel_at_1(const Camera& camera, glm::ivec2 size) {
  return static_cast<float>(2.0 * std::tan(0.5 * camera.fov_y) / size.y);
}

/// False only if no surfel of the frame looks large: not even the largest of them would, where the
/// frame is nearest to the eye.
bool may_look_large(const SceneFrame& frame, const Camera& camera, glm::ivec2 size) {
  const bool is_tree = frame.cloud.empty();
  const std::span all(is_tree ? frame.radii : frame.cloud.radii);
  const std::span radii =
      all.subspan(std::min<std::size_t>(is_tree ? frame.svo.internal_count() : 0, all.size()));
  if (radii.empty()) return false;
  const Box& box = frame.boxes.all;
  if (box.empty()) return true;
  const glm::dvec3 back = camera.axes()[2];
  const glm::dvec3 nearest = glm::mix(box.min, box.max, glm::greaterThan(back, glm::dvec3(0.0)));
  const float largest = *std::max_element(radii.begin(), radii.end());
  // Surfels may lie off the middle of their cells.
  const double away = glm::dot(camera.eye() - nearest, back) - 2.0 * largest;
  return !(largest < kLargePixels * pixel_at_1(camera, size) * away);
}

}  // namespace

/// A surfel to divide.
struct Refinement::Wanted {
  std::uint32_t at;  ///< among the points
  float radius;
  float step;  ///< between new surfels
};

void Refinement::run(std::shared_ptr<const SceneFrame> frame, const Camera& camera,
                     glm::ivec2 size) {
  if (frame != frame_) {
    clear();
    frame_ = std::move(frame);
  }
  if (camera_ == camera && size_ == size) return;
  camera_ = camera;
  size_ = size;
  surfels_.clear();
  divided_.clear();
  // Most pictures show whole figures, whose surfels need not be looked at one by one.
  if (!may_look_large(*frame_, camera, size)) return;
  if (points_.empty()) points_ = surfels_of(*frame_);
  if (!points_.has_normals() || !points_.has_radii()) return;
  std::vector<Wanted> wanted = find_wanted(camera, size);
  if (wanted.empty()) return;
  fit(wanted);
  std::erase_if(wanted, [this](const Wanted& one) {
    return patches_[at_[one.at]].normal == glm::vec3(0.0f);
  });
  divide(wanted);
}

std::vector<Refinement::Wanted> Refinement::find_wanted(const Camera& camera,
                                                        glm::ivec2 size) const {
  const glm::mat4 view = camera.view_from(points_.origin);
  const glm::vec3 eye(camera.eye() - points_.origin);
  const float slope = static_cast<float>(std::tan(0.5 * camera.fov_y));
  const float aspect = static_cast<float>(size.x) / static_cast<float>(size.y);
  const float pixel = pixel_at_1(camera, size);
  std::vector<Wanted> wanted;
  double area = 0.0;
  for (std::uint32_t i = 0; i < points_.size(); ++i) {
    const glm::vec3& position = points_.positions[i];
    const glm::vec3& normal = points_.normals[i];
    const float radius = points_.radii[i], reach = kOwnReach * radius;
    const glm::vec3 at(view * glm::vec4(position, 1.0f));
    const float away = -at.z;
    if (normal == glm::vec3(0.0f) || !(away > reach) || radius < kLargePixels * pixel * away ||
        std::abs(at.y) > slope * away + 2.0f * reach ||
        std::abs(at.x) > aspect * slope * away + 2.0f * reach)
      continue;
    const glm::vec3 way = eye - position;
    const float cosine = glm::dot(way, normal) / glm::length(way);
    const bool is_away = !frame_->normals_estimated && cosine < kAway;
    const float step = std::max(kStepPixels * pixel * away * (is_away ? kStepAway : 1.0f),
                                2.0f * reach / kMostSteps);
    wanted.push_back({i, radius, step});
    area += (radius / step) * (radius / step);
  }
  if (area > kMostSurfels) {
    const auto wider = static_cast<float>(std::sqrt(area / kMostSurfels));
    for (Wanted& one : wanted) one.step *= wider;
  }
  return wanted;
}

void Refinement::fit(std::span<const Wanted> wanted) {
  const Executor executor = tbb_executor();
  if (!surface_) {
    surface_.emplace(points_);
    patches_.resize(points_.size());
    fitted_.resize(points_.size());
    at_.resize(points_.size());
    for (std::uint32_t i = 0; i < points_.size(); ++i) at_[surface_->order()[i].index] = i;
  }
  // Those that may be divided, and those around them, with which they are blended.
  std::vector<float> radii(points_.size(), 0.0f);
  const auto want = [&](std::uint32_t at) {
    if (!fitted_[at]) radii[at] = kSupport * points_.radii[surface_->order()[at].index];
  };
  const auto fit_wanted = [&] {
    surface_->fit_patches(radii, kBeta, patches_, executor);
    for (std::size_t i = 0; i < radii.size(); ++i) {
      const float radius = std::exchange(radii[i], 0.0f) / kSupport;
      if (!(radius > 0.0f)) continue;
      fitted_[i] = true;
      const float most = kMostBend / (kOwnReach * radius);
      patches_[i].curvature = std::clamp(patches_[i].curvature, -most, most);
    }
  };
  for (const Wanted& one : wanted) want(at_[one.at]);
  fit_wanted();
  for (const Wanted& one : wanted) {
    const SurfacePatch& patch = patches_[at_[one.at]];
    for (std::uint32_t n = 0; n < patch.neighbor_count; ++n) want(patch.neighbors[n]);
  }
  fit_wanted();
}

void Refinement::divide(std::span<const Wanted> wanted) {
  const std::size_t tasks = (wanted.size() + kPerTask - 1) / kPerTask;
  std::vector<std::vector<RefinedSurfel>> made(tasks);
  const auto blended_from = [this](std::uint32_t at, const SurfacePatch& divided) {
    const SurfacePatch& patch = patches_[at];
    const glm::vec3 color = points_.has_colors()
                                ? glm::vec3(points_.colors[surface_->order()[at].index])
                                : glm::vec3(0.0f);
    const float reach = kBlended * points_.radii[surface_->order()[at].index];
    return Blended{patch.position,
                   patch.normal,
                   patch.curvature,
                   color,
                   reach,
                   glm::distance(patch.position, divided.position),
                   glm::dot(patch.normal, divided.normal)};
  };
  const auto divide_one = [&](const Wanted& one, std::vector<RefinedSurfel>& out) {
    const SurfacePatch& patch = patches_[at_[one.at]];
    DividedPatch around(blended_from(at_[one.at], patch));
    for (std::uint32_t i = 0; i < patch.neighbor_count; ++i) {
      if (patches_[patch.neighbors[i]].normal != glm::vec3(0.0f))
        around.add(blended_from(patch.neighbors[i], patch));
    }
    around.finish();
    const glm::vec3 n = patch.normal;
    const glm::vec3 across = glm::normalize(
        glm::cross(n, std::abs(n.x) < 0.6f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0)));
    const glm::vec3 along = glm::cross(n, across);
    const float reach = kOwnReach * one.radius;
    const int steps = static_cast<int>(reach / one.step);
    for (int y = -steps; y <= steps; ++y) {
      for (int x = -steps; x <= steps; ++x) {
        const glm::vec2 offset = one.step * glm::vec2(x, y);
        if (glm::dot(offset, offset) > reach * reach) continue;
        std::optional<RefinedSurfel> part = around.surfel_at(offset.x * across + offset.y * along);
        if (!part) continue;
        part->radius = kRadiusOfStep * one.step;
        part->of_divided = one.radius;
        out.push_back(*part);
      }
    }
  };
  for_each(tbb_executor(), static_cast<int>(tasks), [&](int task) {
    const std::size_t begin = static_cast<std::size_t>(task) * kPerTask;
    for (std::size_t i = begin; i < std::min(begin + kPerTask, wanted.size()); ++i) {
      divide_one(wanted[i], made[static_cast<std::size_t>(task)]);
    }
  });
  divided_.resize(points_.size());
  for (const Wanted& one : wanted) divided_[one.at] = true;
  std::size_t count = 0;
  for (const auto& some : made) count += some.size();
  surfels_.reserve(count);
  for (const auto& some : made) surfels_.insert(surfels_.end(), some.begin(), some.end());
}

}  // namespace pointreel
