// A program outside Pointreel's tree: it encodes a small cloud, decodes it and compares.
#include <cstdio>

#include <pointreel/codec.h>

int main() {
  pointreel::PointCloud cloud;
  for (int i = 0; i < 1000; ++i) {
    cloud.positions.emplace_back(i % 10 + 0.5f, i / 10 % 10 + 0.5f, i / 100 + 0.5f);
    cloud.colors.emplace_back(257 * (i % 256), 0, 65535);
  }
  pointreel::OctreeOptions options;
  options.depth = pointreel::DepthRule::fixed(4);
  options.color_quality = pointreel::kLosslessColorQuality;
  const auto frame = pointreel::encode_octree(cloud, {glm::dvec3(0.0), 16.0}, options);
  if (!frame) return std::printf("cannot encode: %s\n", frame.error().message.c_str());
  const auto decoded = pointreel::decode_octree(pointreel::layer_views(frame->layers));
  if (!decoded) return std::printf("cannot decode: %s\n", decoded.error().message.c_str());

  std::size_t equal = 0;  // the points come back in the order of the octree
  for (std::size_t i = 0; i < decoded->cloud.size(); ++i) {
    const glm::ivec3 cell(decoded->cloud.positions[i]);
    const auto source = static_cast<std::size_t>(cell.x + 10 * cell.y + 100 * cell.z);
    if (source < cloud.size() && decoded->cloud.positions[i] == cloud.positions[source] &&
        decoded->cloud.colors[i] == cloud.colors[source]) {
      ++equal;
    }
  }
  std::printf("%zu of %zu points in %zu bytes\n", equal, cloud.size(), frame->size());
  return equal == cloud.size() && decoded->cloud.size() == cloud.size() ? 0 : 1;
}
