#include "client/render/scene_strips.h"

#include <chrono>

#include "client/render/instances.h"
#include "client/render/milliseconds_since.h"

namespace pointreel {

void SceneStrips::update(const Scene& scene, const Camera& camera, glm::ivec2 size,
                         const DrawOptions& options, const SceneInstances& instances,
                         DrawStats& stats) {
  const auto start = std::chrono::steady_clock::now();
  stats.drawn = 0;
  parts_.resize(scene.size());
  points_.clear();
  std::uint32_t vertices = 0;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    Part& part = parts_[i];
    part.strips = nullptr;
    part.frame = scene[i].frame;
    part.first_vertex = vertices;
    const SceneFrame* frame = scene[i].frame.get();
    if (frame == nullptr) continue;
    part.strips = &frame->strips;
    vertices += static_cast<std::uint32_t>(frame->cloud.size());
    const glm::dvec3 place = scene[i].place + frame->cloud.origin;
    cut_strips(frame->strips,
               {.camera = camera,
                .origin = place,
                .size = size,
                .pixel_size = options.pixel_size,
                .signs_unknown = instances.normals_estimated()},
               part.cut);
    for (const std::uint32_t node : part.cut.points)
      points_.push_back(pack_representative(*frame, frame->strips.nodes[node], options.color,
                                            glm::vec3(place - instances.origin())));
    stats.drawn += part.cut.triangles + static_cast<std::uint32_t>(part.cut.points.size());
    stats.visited += part.cut.visited;
    stats.out_of_view += part.cut.out_of_view;
    stats.below_pixel += part.cut.below_pixel;
    stats.hidden += part.cut.backs;
  }
  stats.cut_ms += milliseconds_since(start);
}

}  // namespace pointreel
