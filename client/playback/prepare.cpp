#include "client/playback/prepare.h"

#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "client/playback/tree_radii.h"
#include "codec/cloud_file.h"
#include "common/base/tbb_executor.h"
#include "common/surface/normals.h"

namespace pointreel {
namespace {

class Stopwatch {
 public:
  /// Milliseconds since it was made or last asked.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double, std::milli>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

Result<DecodedFrame> decode(const Manifest& manifest, std::uint32_t index,
                            const FetchedFrame& fetched, DrawMode mode) {
  if (fetched.layers.empty()) {
    auto loaded = read_cloud(fetched.file);
    if (!loaded) return fail_at(fetched.file_name, loaded.error());
    DecodedFrame frame;
    frame.cloud = std::move(loaded->cloud);
    frame.cube = bounding_cube(bounds(frame.cloud));
    frame.source_points = static_cast<std::uint32_t>(frame.cloud.size());
    return frame;
  }
  std::vector<LayerView> views;
  for (const FetchedLayer& layer : fetched.layers) views.push_back(layer.view());
  DecodeLimits limits;
  limits.tables = fetched.tables.get();
  limits.executor = tbb_executor();
  limits.inner_nodes = mode == DrawMode::voxel;
  auto frame = decode_frame(views, limits);
  // A cloud without a tree of its own gets one in the cube that its segment shares, so that voxels
  // do not jump from frame to frame (ERRATA 12).
  if (frame && !frame->svo) frame->cube = manifest.segments[locate(manifest, index).segment].cube;
  return frame;
}

/// Whether a mode draws normals of a cloud, coloured or not.
bool draws_normals(DrawMode mode, bool colored) { return mode == DrawMode::surfel || !colored; }

/// Adds the normals that the mode needs, and takes away those that it does not, so that a reel
/// looks the same wherever it comes from.
void derive_normals(SceneFrame& scene, DrawMode mode) {
  PointCloud& cloud = scene.cloud;
  if (!draws_normals(mode, cloud.has_colors())) {
    cloud.normals.clear();
  } else if (!cloud.has_normals()) {
    estimate_normals(cloud);
    scene.normals_estimated = true;
  }
}

/// The coarsest level that satisfies `delta` of a tree that is already there.
Result<int> depth_of(const Svo& svo, std::uint64_t source_points, double delta) {
  std::vector<std::uint32_t> occupied;
  for (int level = 0; level <= svo.depth; ++level) occupied.push_back(svo.node_count(level));
  return choose_depth(occupied, source_points, DepthRule::by_delta(delta));
}

/// What the nodes of a decoded tree look like: as they were decoded, or the means of its leaves.
NodeAttributes node_attributes(DecodedFrame& frame, const PointCloud& leaves) {
  const bool colors = !leaves.has_colors() || !frame.attributes.colors.empty();
  const bool normals = !leaves.has_normals() || !frame.attributes.normals.empty();
  if (!colors || !normals) return mean_attributes(*frame.svo, leaves);
  if (!leaves.has_normals()) frame.attributes.normals.clear();
  return std::move(frame.attributes);
}

/// The tree, and what is derived from it.
Result<void> make_tree(SceneFrame& scene, DecodedFrame& frame, const PrepareOptions& options) {
  const bool with_attributes = options.mode == DrawMode::voxel;
  const bool with_radii = options.mode == DrawMode::surfel && !scene.cloud.has_radii();
  if (frame.svo) {
    const auto depth = depth_of(*frame.svo, frame.source_points, options.delta);
    if (!depth) return tl::unexpected(depth.error());
    if (with_attributes) scene.attributes = node_attributes(frame, scene.cloud);
    if (with_radii) scene.cloud.radii = leaf_radii(*frame.svo);
    scene.svo = *depth < frame.svo->depth ? truncate(*frame.svo, *depth) : std::move(*frame.svo);
    // Nodes are numbered from the root down: a coarser tree's attributes are the first ones.
    const std::size_t nodes = scene.svo.node_count();
    if (scene.attributes.colors.size() > nodes) scene.attributes.colors.resize(nodes);
    if (scene.attributes.normals.size() > nodes) scene.attributes.normals.resize(nodes);
    return {};
  }
  const auto sorted = sort_to_depth(scene.cloud, frame.cube, DepthRule::by_delta(options.delta));
  if (!sorted) return tl::unexpected(sorted.error());
  scene.svo = build_svo(sorted->sorted, sorted->depth);
  if (with_attributes) scene.attributes = mean_attributes(scene.svo, scene.cloud, sorted->sorted);
  if (with_radii) scene.cloud.radii = point_radii(scene.svo, sorted->sorted);
  return {};
}

}  // namespace

FetchRequest parts_for(const Manifest& manifest, DrawMode mode) {
  FetchRequest request;
  request.normals = draws_normals(mode, manifest.colors);
  return request;
}

Result<SceneFrame> prepare_frame(const Manifest& manifest, std::uint32_t index,
                                 const FetchedFrame& fetched, const PrepareOptions& options) {
  Stopwatch watch;
  auto frame = decode(manifest, index, fetched, options.mode);
  if (!frame) return tl::unexpected(frame.error());

  SceneFrame scene;
  scene.index = index;
  scene.time_us = frame_time_us(manifest, index);
  scene.cloud = std::move(frame->cloud);
  scene.decode_ms = watch.lap();
  derive_normals(scene, options.mode);
  scene.normals_ms = watch.lap();
  if (const auto made = make_tree(scene, *frame, options); !made)
    return tl::unexpected(made.error());
  scene.svo_ms = watch.lap();
  return scene;
}

}  // namespace pointreel
