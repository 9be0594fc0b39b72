#include "codec/draco/part_sizes.h"

#include <algorithm>

#include "common/base/try.h"

namespace pointreel {

namespace {

Chunks<std::size_t> octree_part_sizes(const EncodedFrame& frame) {
  Chunks<std::size_t> sizes;
  for (const Chunks<Bytes>& layer : frame.layers) {
    sizes.geometry += layer.geometry.size();
    sizes.colors += layer.colors.size();
    sizes.normals += layer.normals.size();
  }
  sizes.geometry -= frame.scalar_bytes();
  return sizes;
}

}  // namespace

Result<Chunks<std::size_t>> measure_part_sizes(const EncodedFrame& frame, const PointCloud& cloud,
                                               const Cube& cube, const EncodeOptions& options) {
  if (options.id() == Codec::octree) return octree_part_sizes(frame);
  const bool normals = options.normals && cloud.has_normals();
  const bool colors = options.colors && cloud.has_colors();
  const std::size_t size = frame.size();
  EncodeOptions fewer = options;
  fewer.normals = fewer.colors = false;
  std::size_t positions = size, colored = size;
  if (normals || colors) {
    positions = std::min(TRY(encode_frame(cloud, cube, fewer)).size(), size);
    if (!colors) colored = positions;
  }
  if (normals && colors) {
    fewer.colors = true;
    colored = std::clamp(TRY(encode_frame(cloud, cube, fewer)).size(), positions, size);
  }
  return Chunks<std::size_t>{positions, colored - positions, size - colored};
}

}  // namespace pointreel
