#include "client/render/scene_instances.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <string>

#include "client/render/milliseconds_since.h"

namespace pointreel {
namespace {

const glm::dvec3& origin_of(const SceneFrame& frame, bool is_tree) {
  return is_tree ? frame.svo.cube.origin : frame.cloud.origin;
}

}  // namespace

Result<void> SceneInstances::update(const Scene& scene, const Camera& camera, glm::ivec2 size,
                                    const ElementStyle& style, float pixel_size,
                                    InstanceMemory& memory) {
  stats_.cut_ms = 0.0;
  const View view{camera, size, pixel_size};
  const bool same = view_ && scene == scene_ && style == style_;
  const bool trees =
      std::any_of(parts_.begin(), parts_.end(), [](const Part& part) { return part.is_tree; });
  if (same && view_ == view) return {};
  if (same && !trees && !style.refine) return {};
  scene_ = scene;
  style_ = style;
  view_ = view;
  stats_ = {};
  cut(scene);
  std::size_t most = 0;
  for (const Part& part : parts_) most += part.most;
  const std::span<Instance> out = memory.write(most);
  if (out.size() < most) {
    view_.reset();
    stats_ = {};
    return fail(ErrorCode::limit,
                "there is no memory to draw " + std::to_string(most) + " elements");
  }
  origin_ = glm::dvec3(0.0);
  bounds_ = {};
  std::size_t count = 0;
  undivided_ = 0;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    if (!scene[i].frame) continue;
    if (count == 0) origin_ = scene[i].place + origin_of(*scene[i].frame, parts_[i].is_tree);
    const std::size_t packed = pack(scene[i], parts_[i], out.subspan(count, parts_[i].most));
    count += packed;
    undivided_ += packed - parts_[i].refinement.surfels().size();
  }
  memory.keep(count);
  return {};
}

void SceneInstances::cut(const Scene& scene) {
  const auto start = std::chrono::steady_clock::now();
  bool any = false;
  normals_estimated_ = colored_ = false;
  parts_.resize(scene.size());
  for (std::size_t i = 0; i < scene.size(); ++i) {
    Part& part = parts_[i];
    part.stats = {};
    part.most = 0;
    part.is_tree = false;
    const SceneFrame* frame = scene[i].frame.get();
    if (frame == nullptr) {
      part.refinement.clear();
      continue;
    }
    Camera camera = view_->camera;
    camera.target -= scene[i].place;
    if (style_.refine && style_.mode == DrawMode::surfel) {
      part.refinement.run(scene[i].frame, camera, view_->size);
      any = true;
    } else {
      part.refinement.clear();
    }
    part.most = part.refinement.surfels().size();
    normals_estimated_ = normals_estimated_ || frame->normals_estimated;
    colored_ = colored_ || shows_own_colors(*frame, style_.color);
    part.is_tree = style_.mode == DrawMode::voxel || frame->cloud.empty();
    if (!part.is_tree) {
      part.most += frame->cloud.size();
      continue;
    }
    part.stats = part.cut.run(frame->svo, camera, view_->size, view_->pixel_size);
    part.most += part.cut.nodes().size();
    any = true;
  }
  if (!any) return;
  stats_.cut_ms = milliseconds_since(start);
}

std::size_t SceneInstances::pack(const PlacedFrame& placed, const Part& part,
                                 std::span<Instance> out) {
  const SceneFrame& frame = *placed.frame;
  const glm::dvec3 origin = placed.place + origin_of(frame, part.is_tree);
  const glm::vec3 offset(origin - origin_);
  const std::vector<RefinedSurfel>& refined = part.refinement.surfels();
  const std::vector<bool>& divided = part.refinement.divided();
  pack_refined(frame, refined, style_.color, offset, out.first(refined.size()), bounds_);
  const std::span<Instance> rest = out.subspan(refined.size());
  if (!part.is_tree)
    return refined.size() + pack_points(frame, style_, offset, divided, rest, bounds_, executor_);
  const glm::vec3 eye(view_->camera.eye() - origin);
  const std::size_t count =
      pack_nodes(frame, part.cut.nodes(), style_, eye, offset, divided, rest, bounds_, executor_);
  stats_.visited += part.stats.visited;
  stats_.out_of_view += part.stats.out_of_view;
  if (part.stats.visited > 0) {
    stats_.below_pixel += frame.svo.leaf_count() - part.stats.out_of_view - part.stats.emitted;
    if (style_.mode == DrawMode::voxel)
      stats_.hidden += part.stats.emitted - static_cast<std::uint32_t>(count);
  }
  return refined.size() + count;
}

}  // namespace pointreel
