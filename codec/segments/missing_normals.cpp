#include "codec/segments/missing_normals.h"

#include <algorithm>
#include <utility>

namespace pointreel {
namespace {

/// Deriving the normals of so many points takes a player on two cores about 80 ms.
constexpr std::size_t kManyPoints = 100'000;
/// Quality of estimated normals in a frame with colours, whose light is weak (codec/QUALITY.md,
/// "Estimated normals").
constexpr int kRoughNormals = 20;

}  // namespace

bool encodes_normals(const PackOptions& options) {
  return options.encode.normals && options.encode.id() == Codec::octree && !options.video;
}

void choose_normals(std::span<const CloudFrame> frames, PackOptions& options) {
  if (options.missing_normals == MissingNormals::derived) return;
  LoadedCloud first;
  if (!frames.empty() && encodes_normals(options)) {
    // One that cannot be read is reported when it is packed.
    auto read = read_cloud_frame(
        frames.front(), {.max_memory = options.max_memory, .executor = options.encode.executor});
    if (read) first = std::move(*read);
  }
  choose_normals(first.cloud, options);
}

void choose_normals(const PointCloud& first, PackOptions& options) {
  if (options.missing_normals == MissingNormals::derived) return;
  const bool if_it_pays = options.missing_normals == MissingNormals::estimated_if_it_pays;
  if (if_it_pays) options.missing_normals = MissingNormals::derived;
  if (!encodes_normals(options) || first.has_normals()) return;
  const bool colors = options.encode.colors && first.has_colors();
  if (if_it_pays && (!colors || first.size() < kManyPoints)) return;
  options.missing_normals = MissingNormals::estimated;
  auto& octree = std::get<OctreeOptions>(options.encode.codec);
  if (colors && octree.normals_follow_noise)
    octree.normal_quality = std::min(octree.normal_quality, kRoughNormals);
}

}  // namespace pointreel
