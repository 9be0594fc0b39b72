#include "datasets_synthetic/sequences.h"

#include "datasets_synthetic/random.h"
#include "datasets_synthetic/samplers/uniform.h"

namespace pointreel {

Result<PointCloud> sequence_frame(const Motion& motion, const SequenceOptions& options,
                                  int number) {
  const Body body = pose_body(motion.pose(static_cast<double>(number) / options.fps));
  const auto stream = static_cast<std::uint64_t>(number);
  const std::uint64_t seed = Random(options.seed, 2 * stream).bits();
  const std::uint64_t noise_seed = Random(options.seed, 2 * stream + 1).bits();
  const auto points = sample_uniform(body.surface, options.points, seed);
  if (!points) return tl::unexpected(points.error());

  PointCloud cloud;
  cloud.positions.reserve(points->size());
  cloud.normals.reserve(points->size());
  cloud.colors.reserve(points->size());
  for (std::size_t i = 0; i < points->size(); ++i) {
    const SurfacePoint& point = (*points)[i];
    glm::dvec3 position = point.position;
    if (options.noise > 0.0) {
      Random random(noise_seed, i);
      const double x = random.normal(), y = random.normal(), z = random.normal();
      position += options.noise * glm::dvec3(x, y, z);
    }
    cloud.positions.emplace_back(position);
    cloud.normals.emplace_back(point.normal);
    const glm::u8vec3 color = color_at(body, point.primitive, point.position);
    cloud.colors.push_back(glm::u16vec3(color) * std::uint16_t{257});
  }
  return cloud;
}

}  // namespace pointreel
