#include "client/scene/refinement.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/for_each.h"
#include "common/base/median.h"
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
/// one, and the radius within which spheres and colours are blended, all in distances between
/// neighbours.
constexpr float kSupport = 3.0f, kOwnReach = 1.4f, kBlended = 1.8f;
/// So many points lie within kSupport where points cover the surface evenly: pi * kSupport^2.
constexpr double kSupported = 28.0;
/// Points cover the surface evenly if they extend at least so far in every direction along it
/// (SurfaceEvidence::extent), at the median of about so many points.
constexpr float kEvenExtent = 0.06f;
constexpr std::size_t kMeasured = 2048;
constexpr double kBeta = 0.8;
/// A sphere bends by no more than so much within the reach of a surfel: the sine of the angle. At
/// the edges of surfaces, smaller spheres would stand out as curls.
constexpr float kMostBend = 0.6f;
/// Surfels that face away further than this, as a cosine, are only seen as the insides of holes,
/// and their outlines must not stand out. For that, new surfels may be further apart by this
/// factor.
constexpr float kAway = -0.25f, kStepAway = 2.0f;
constexpr std::size_t kPerTask = 256;
constexpr std::uint32_t kNoSlot = ~0u;

/// About the distance between neighbours, for each point of the surface. It is the radius of their
/// surfels, which are larger where the octree that they come from has large cells. They have to be
/// if points are dense along curves with gaps between them, but would smear the detail of points
/// that cover the surface evenly.
std::vector<float> spacings_of(const PointSurface& surface, const PointCloud& points) {
  const Executor executor = tbb_executor();
  std::vector<float> spacings(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    spacings[i] = points.radii[surface.order()[i].index];
  const std::vector<float> supports = surface.radii_of(kSupported);
  const auto one_in = static_cast<std::uint32_t>(points.size() / kMeasured + 1);
  std::vector<float> extents;
  for (const SurfaceEvidence& evidence : surface.measure(supports, kBeta, one_in, executor))
    if (evidence.weight > 0.0f) extents.push_back(evidence.extent);
  if (extents.empty() || median(std::move(extents)) < kEvenExtent) return spacings;
  for (std::size_t i = 0; i < points.size(); ++i)
    spacings[i] = std::min(spacings[i], supports[i] / kSupport);
  return spacings;
}

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
    return patches_[slots_[at_[one.at]]].normal == glm::vec3(0.0f);
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
    slots_.assign(points_.size(), kNoSlot);
    at_.resize(points_.size());
    for (std::uint32_t i = 0; i < points_.size(); ++i) at_[surface_->order()[i].index] = i;
    spacings_ = spacings_of(*surface_, points_);
  }
  // Those that may be divided, and those around them, with which they are blended.
  std::vector<float> radii(points_.size(), 0.0f);
  std::vector<std::uint32_t> fresh;
  const auto want = [&](std::uint32_t at) {
    if (slots_[at] != kNoSlot) return;
    slots_[at] = static_cast<std::uint32_t>(patches_.size() + fresh.size());
    radii[at] = kSupport * spacings_[at];
    fresh.push_back(at);
  };
  const auto fit_wanted = [&] {
    patches_.resize(patches_.size() + fresh.size());
    surface_->fit_patches(radii, kBeta, slots_, patches_, executor);
    for (const std::uint32_t at : std::exchange(fresh, {})) {
      radii[at] = 0.0f;
      const float most = kMostBend / (kOwnReach * spacings_[at]);
      float& curvature = patches_[slots_[at]].curvature;
      curvature = std::clamp(curvature, -most, most);
    }
  };
  for (const Wanted& one : wanted) want(at_[one.at]);
  fit_wanted();
  for (const Wanted& one : wanted) {
    const SurfacePatch& patch = patches_[slots_[at_[one.at]]];
    for (std::uint32_t n = 0; n < patch.neighbor_count; ++n) want(patch.neighbors[n]);
  }
  fit_wanted();
}

void Refinement::divide(std::span<const Wanted> wanted) {
  const std::size_t tasks = (wanted.size() + kPerTask - 1) / kPerTask;
  std::vector<std::vector<RefinedSurfel>> made(tasks);
  const auto blended_from = [this](std::uint32_t at, const SurfacePatch& divided) {
    const SurfacePatch& patch = patches_[slots_[at]];
    const glm::vec3 color = points_.has_colors()
                                ? glm::vec3(points_.colors[surface_->order()[at].index])
                                : glm::vec3(0.0f);
    const float reach = kBlended * spacings_[at];
    return Blended{patch.position,
                   patch.normal,
                   patch.curvature,
                   color,
                   reach,
                   glm::distance(patch.position, divided.position),
                   glm::dot(patch.normal, divided.normal)};
  };
  const auto divide_one = [&](const Wanted& one, std::vector<RefinedSurfel>& out) {
    const SurfacePatch& patch = patches_[slots_[at_[one.at]]];
    DividedPatch around(blended_from(at_[one.at], patch));
    for (std::uint32_t i = 0; i < patch.neighbor_count; ++i) {
      if (patches_[slots_[patch.neighbors[i]]].normal != glm::vec3(0.0f))
        around.add(blended_from(patch.neighbors[i], patch));
    }
    around.finish();
    const std::size_t first = out.size();
    around.divide(kOwnReach * spacings_[at_[one.at]], one.step, out);
    for (RefinedSurfel& surfel : std::span(out).subspan(first)) {
      surfel.radius = kRadiusOfStep * one.step;
      surfel.of_divided = one.radius;
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
