#include "client/prepare/prepare.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "client/prepare/layer_choice.h"
#include "client/prepare/leaf_points.h"
#include "client/prepare/main_box.h"
#include "client/prepare/node_radii.h"
#include "client/prepare/point_spacing.h"
#include "client/prepare/strip_frame.h"
#include "client/prepare/tree_radii.h"
#include "client/scene/scalar_colors.h"
#include "client/source/decode_fetched.h"
#include "codec/core/build.h"
#include "codec/core/lattice.h"
#include "codec/core/normal_lines.h"
#include "codec/core/scalar_fields.h"
#include "codec/surface/leaf_heights.h"
#include "codec/surface/normals.h"
#include "common/base/try.h"
#include "common/threads/tbb_executor.h"

namespace pointreel {
namespace {

class Stopwatch {
 public:
  /// Milliseconds since it was made or last called.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double, std::milli>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// A tree is worth building for surfels and points if it has no more leaves than this share of the
/// points.
constexpr double kWorthATree = 0.7;
/// The fewest cells of a level that any surface worth drawing fills if it has the points to do so,
/// as a share of the square of the cells along the cube's edge.
constexpr double kLeastFilled = 0.25;

/// Fewer points are drawn as they are in so little time that it does not matter which are seen.
constexpr std::size_t kManyPoints = 1u << 17;
/// How many leaves a tree has at least for each node on the level above them, where the leaves
/// touch each other. It is four on a closed surface.
constexpr double kClosed = 2.8;
/// The finest level of a view has nodes smaller than a pixel, and light on them changes little if
/// their normals are coarser by so many levels.
constexpr int kCoarserNormals = 1;

constexpr glm::u16vec3 kUnknown = glm::u16vec3(kUnknownColor) * std::uint16_t{257};

/// Cells that are larger by this factor look as large.
constexpr double kSameSize = 1.1;

Result<void> check(const std::function<bool()>& stopped) {
  if (stopped && stopped()) return fail(ErrorCode::cancelled, "the frame is not wanted any more");
  return {};
}

/// The finest level at which nodes have normals of their own.
int normals_level(const PrepareOptions& options) {
  if (options.mode != DrawMode::surfel || options.show_normals || options.level == kWholeFrame)
    return kWholeFrame;
  return std::max(options.level - kCoarserNormals, 0);
}

Result<DecodedFrame> decode(const FetchedFrame& fetched, const Cube& cube,
                            const PrepareOptions& options, const std::function<bool()>& stopped) {
  DecodeLimits limits;
  limits.max_memory = options.max_memory;
  limits.executor = tbb_executor();
  limits.stopped = stopped;
  limits.inner_nodes = true;
  limits.leaves = false;
  limits.scalars = !options.scalar.field.empty();
  limits.scalar = options.scalar.field;
  limits.depth = limits.scalars ? kWholeFrame : options.level;
  limits.normals_depth = normals_level(options);
  limits.spacing = spacing_for(options, cube);
  auto frame = decode_fetched(fetched, limits);
  if (fetched.layers.empty()) return frame;
  // A cloud without a tree of its own gets one in the cube that all frames of its segment share, so
  // that voxels do not jump from frame to frame (common/FORMULAS.md, "Cube of a frame").
  if (frame && !frame->svo) frame->cube = cube;
  return frame;
}

/// How a field of the frame is shown.
ShownScalar shown_scalar(const ScalarField& field, const ScalarChoice& choice,
                         const std::vector<ScalarRange>& of_source) {
  const ScalarSummary summary = summary_of(field.values);
  ShownScalar shown{{field.name, summary.least, summary.most, summary.labels()}, {}};
  for (const ScalarRange& range : of_source)
    if (range.name == field.name) shown.range = range;
  if (choice.range) {
    shown.range.least = choice.range->x;
    shown.range.most = choice.range->y;
    shown.range.labels = false;
  }
  if (!shown.range.labels) return shown;
  std::set<int> labels;
  for (const float value : field.values)
    if (summary.distinct > 0 && !std::isnan(value)) labels.insert(static_cast<int>(value));
  shown.labels.assign(labels.begin(), labels.end());
  return shown;
}

const ScalarField* find_field(const std::vector<ScalarField>& fields, const std::string& name) {
  const auto found =
      std::ranges::find_if(fields, [&](const ScalarField& field) { return field.name == name; });
  return found == fields.end() ? nullptr : &*found;
}

/// Colours a tree by the values of its leaves.
void color_by_scalar(SceneFrame& scene, const std::vector<ScalarField>& fields,
                     const FrameInfo& info, const ScalarChoice& choice) {
  if (const ScalarField* field = find_field(fields, choice.field)) {
    scene.scalar = shown_scalar(*field, choice, info.scalars);
    scene.attributes.colors = scalar_node_colors(*scene.scalar, scene.svo, field->values);
  } else {
    scene.attributes.colors.assign(scene.svo.node_count(), kUnknown);
  }
}

/// The same for a cloud.
void color_by_scalar(SceneFrame& scene, const FrameInfo& info, const ScalarChoice& choice) {
  PointCloud& cloud = scene.cloud;
  if (const ScalarField* field = find_field(cloud.scalars, choice.field)) {
    scene.scalar = shown_scalar(*field, choice, info.scalars);
    cloud.colors = scalar_colors(*scene.scalar, field->values);
  } else {
    cloud.colors.assign(cloud.size(), kUnknown);
  }
}

/// Adds the normals that the mode needs, and removes those that it does not need, so that a reel
/// looks the same wherever it comes from.
void derive_normals(SceneFrame& scene, const FrameInfo& info, const PrepareOptions& options) {
  PointCloud& cloud = scene.cloud;
  if (!draws_normals(options.mode, cloud.has_colors(), options.show_normals)) {
    cloud.normals.clear();
    return;
  }
  scene.normals_estimated = info.normals_estimated || !cloud.has_normals();
  if (!cloud.has_normals()) estimate_normals(cloud, tbb_executor());
}

/// The same for a tree.
void derive_node_normals(SceneFrame& scene, const FrameInfo& info, const PrepareOptions& options) {
  NodeAttributes& attributes = scene.attributes;
  if (!draws_normals(options.mode, !attributes.colors.empty(), options.show_normals)) {
    attributes.normals.clear();
    return;
  }
  scene.normals_estimated = info.normals_estimated || attributes.normals.empty();
  if (!attributes.normals.empty()) return;
  PointCloud leaves = leaf_centers(scene.svo);
  estimate_normals(leaves, tbb_executor());
  attributes.normals = mean_normal_lines(scene.svo, leaves, tbb_executor());
}

/// The rule for the level that is drawn as voxels. A few points lie apart on any level; their
/// voxels must not be as large as the scene.
DepthRule voxel_rule(double delta) {
  DepthRule rule = DepthRule::by_delta(delta);
  rule.least = 3;
  return rule;
}

/// The number of cells at each level of a tree.
std::vector<std::uint32_t> cells_of(const Svo& svo) {
  std::vector<std::uint32_t> cells;
  for (int level = 0; level <= svo.depth; ++level) cells.push_back(svo.node_count(level));
  return cells;
}

/// Cuts the tree off at the level that is drawn as voxels.
Result<void> coarsen(SceneFrame& scene, double delta) {
  const std::vector<std::uint32_t> occupied = cells_of(scene.svo);
  const int by_delta = TRY(choose_depth(occupied, scene.points, voxel_rule(delta)));
  const int depth = depth_that_closes(occupied, scene.points, by_delta, delta);
  const double leaves = occupied[static_cast<std::size_t>(depth)];
  if (leaves >= (1.0 - delta) * scene.points) scene.level = kWholeFrame;
  if (depth < scene.svo.depth) scene.svo = truncate(scene.svo, depth);
  // Nodes are numbered from the root down, so that a coarser tree's attributes come first.
  const std::size_t nodes = scene.svo.node_count();
  if (scene.attributes.colors.size() > nodes) scene.attributes.colors.resize(nodes);
  if (scene.attributes.normals.size() > nodes) scene.attributes.normals.resize(nodes);
  return {};
}

/// Frames with more leaves keep their surfels in the middle of the voxels, unless there are points
/// to tell better. These are so small that it hardly shows, and heights would take longer than
/// decoding: 250 ms for 900,000 leaves.
constexpr std::uint32_t kMostHeights = 1u << 18;

std::span<const glm::i16vec3> leaf_normals(const SceneFrame& scene) {
  const std::vector<glm::i16vec3>& normals = scene.attributes.normals;
  return std::span(normals).subspan(normals.empty() ? 0 : scene.svo.internal_count());
}

/// What surfels need: how large they are, and where the surface is.
void make_surfels(SceneFrame& scene, const std::vector<float>& radii) {
  scene.radii = node_radii(scene.svo, radii, tbb_executor());
  const std::span normals = leaf_normals(scene);
  if (normals.empty() || scene.svo.leaf_count() > kMostHeights) return;
  scene.heights = leaf_heights(scene.svo, normals, scene.normals_estimated);
}

/// Fills the tree with the means of the cloud's attributes.
void add_tree(SceneFrame& scene, const SortedPoints& sorted, int depth) {
  const Executor executor = tbb_executor();
  scene.svo = build_svo(sorted, depth, executor);
  std::vector<glm::i16vec3> lines;
  if (scene.normals_estimated) {
    lines = mean_normal_lines(scene.svo, scene.cloud, sorted, executor);
    scene.cloud.normals.clear();
  }
  scene.attributes = mean_attributes(scene.svo, scene.cloud, sorted, executor);
  if (scene.normals_estimated) scene.attributes.normals = std::move(lines);
}

/// Prepares a cloud to be drawn as voxels.
Result<void> make_voxels(SceneFrame& scene, const Cube& cube, const PrepareOptions& options) {
  DepthRule rule = voxel_rule(options.delta);
  rule.most = options.level;
  const auto tree = TRY(sort_to_depth(scene.cloud, cube, rule, tbb_executor()));
  if (tree.depth == options.level) scene.level = options.level;
  add_tree(scene, tree.sorted,
           depth_that_closes(tree.sorted.occupied, scene.cloud.size(), tree.depth, options.delta));
  scene.cloud = {};
  return {};
}

/// Enough levels to tell the spacing of a million points on a surface.
constexpr int kSpacingLevels = 10;

/// Whether the finest cells lie side by side, so that the tree has hardly more nodes than leaves.
bool is_closed(const std::vector<std::uint32_t>& occupied) {
  return occupied.size() > 1 && occupied.back() >= kClosed * occupied[occupied.size() - 2];
}

/// Replaces the cloud by a tree of it, for surfels or points.
void use_tree(SceneFrame& scene, const SortedPoints& sorted, int depth, bool with_radii) {
  add_tree(scene, sorted, depth);
  if (with_radii) {
    make_surfels(scene, scene.cloud.has_radii() ? own_radii(scene.svo, scene.cloud, sorted)
                                                : leaf_radii(scene.svo));
    // Voxels with a single point have it in their middle.
    const std::span normals = leaf_normals(scene);
    if (scene.heights.empty() && !normals.empty() && scene.svo.leaf_count() < scene.cloud.size())
      scene.heights = point_heights(scene.svo, scene.cloud, sorted, normals);
  } else {
    scene.spacing = point_spacing(cells_of(scene.svo), scene.svo.cube.edge, scene.cloud.size());
  }
  scene.cloud = {};
}

/// The voxels of a voxelised cloud, if it is large and they are worth a tree.
std::optional<VoxelCube> voxels_of(const PointCloud& cloud) {
  if (cloud.size() < kManyPoints) return std::nullopt;
  const auto lattice = lattice_of(cloud);
  if (!lattice) return std::nullopt;
  const VoxelCube voxels = lattice_cube(bounds(cloud), *lattice);
  if (voxels.depth == 0 || voxels.depth > kMaxDepth) return std::nullopt;
  return voxels;
}

/// Prepares a cloud to be drawn as surfels or points: its points, or a tree as deep as the view
/// shows, if that has much fewer elements or loses nothing.
Result<void> make_elements(SceneFrame& scene, const Cube& cube, const PrepareOptions& options) {
  const auto points = static_cast<double>(scene.cloud.size());
  const bool with_radii = options.mode != DrawMode::point;
  const auto voxels = voxels_of(scene.cloud);
  Cube grid = cube;
  int level = options.level;
  if (voxels) {
    grid = voxels->cube;
    // The level was found for the cells of the other cube.
    for (double edge = kSameSize * cube.edge; edge < grid.edge && level < voxels->depth; edge *= 2)
      ++level;
    level = std::min(level, voxels->depth);
  }
  const bool all_voxels = voxels && level == voxels->depth;
  if (all_voxels || points * kWorthATree > kLeastFilled * std::pow(4.0, level)) {
    const SortedPoints sorted = sort_points(scene.cloud, grid, level, tbb_executor());
    const bool few = sorted.occupied.back() <= kWorthATree * points;
    if (few || (all_voxels && is_closed(sorted.occupied))) {
      if (!all_voxels) scene.level = options.level;
      use_tree(scene, sorted, level, with_radii);
      return {};
    }
  }
  if (options.mode == DrawMode::point) {
    const SortedPoints sorted = sort_points(scene.cloud, cube, kSpacingLevels, tbb_executor());
    scene.spacing = point_spacing(sorted.occupied, cube.edge, scene.cloud.size());
  }
  if (with_radii && !scene.cloud.has_radii()) {
    const Executor executor = tbb_executor();
    const auto tree =
        TRY(sort_to_depth(scene.cloud, cube, DepthRule::by_delta(options.delta), executor));
    scene.cloud.radii = point_radii(build_svo(tree.sorted, tree.depth, executor), tree.sorted);
  }
  return {};
}

}  // namespace

FrameInfo frame_info(const Manifest& manifest, std::uint32_t index) {
  const Segment& segment = manifest.segments[locate(manifest, index).segment];
  return {index, frame_time_us(manifest, index), segment.cube, manifest.scalars,
          manifest.normals_estimated};
}

double spacing_for(const PrepareOptions& options, const Cube& cube) {
  const bool any = options.mode == DrawMode::surfel || options.mode == DrawMode::point;
  return any && options.level < kWholeFrame ? std::ldexp(cube.edge, -options.level) : 0.0;
}

Result<SceneFrame> prepare_frame(const FetchedFrame& fetched, const FrameInfo& info,
                                 const PrepareOptions& options,
                                 const std::function<bool()>& stopped,
                                 std::shared_ptr<const StripRecord>* record) {
  Stopwatch watch;
  TRY(check(stopped));
  auto frame = TRY(decode(fetched, info.cube, options, stopped));
  const double decode_ms = watch.lap();
  auto scene = TRY(prepare_decoded(std::move(frame), info, options, stopped, record));
  scene.layers = static_cast<std::uint32_t>(fetched.layers.size());
  scene.decode_ms = decode_ms;
  return scene;
}

Result<SceneFrame> prepare_decoded(DecodedFrame frame, const FrameInfo& info,
                                   const PrepareOptions& options,
                                   const std::function<bool()>& stopped,
                                   std::shared_ptr<const StripRecord>* record) {
  Stopwatch watch;
  TRY(check(stopped));
  SceneFrame scene;
  scene.index = info.index;
  scene.time_us = info.time_us;
  scene.points = frame.source_points;
  const bool by_scalar = !options.scalar.field.empty();
  const bool lacks_scalar = by_scalar && frame.svo && frame.scalars.empty();
  if (frame.svo) {
    scene.svo = std::move(*frame.svo);
    scene.attributes = std::move(frame.attributes);
    if (by_scalar) color_by_scalar(scene, frame.scalars, info, options.scalar);
    const bool whole = scene.svo.depth == frame.depth;
    if (!whole || (!scene.attributes.normals.empty() && normals_level(options) < frame.depth))
      scene.level = scene.svo.depth;
    // The size of a single cell may be that of many points that look like one from afar. A few
    // points in it may as well coincide.
    constexpr std::uint32_t kMany = 100;
    scene.boxes = frame_boxes(scene.svo, scene.points, whole);
    if (scene.svo.leaf_count() <= 1 && scene.points < kMany) scene.boxes.main = {};
    derive_node_normals(scene, info, options);
    scene.normals_ms = watch.lap();
    TRY(check(stopped));
    if (options.mode == DrawMode::voxel) {
      TRY(coarsen(scene, options.delta));
    } else if (options.mode != DrawMode::point) {
      make_surfels(scene, leaf_radii(scene.svo));
    } else {
      scene.spacing = point_spacing(cells_of(scene.svo), scene.svo.cube.edge, scene.points);
    }
  } else {
    if (frame.cloud.size() < frame.source_points) scene.level = options.level;
    scene.cloud = std::move(frame.cloud);
    if (by_scalar) color_by_scalar(scene, info, options.scalar);
    scene.cloud.scalars = {};
    scene.boxes = frame_boxes(scene.cloud);
    derive_normals(scene, info, options);
    scene.normals_ms = watch.lap();
    TRY(check(stopped));
    if (options.mode == DrawMode::voxel) {
      TRY(make_voxels(scene, frame.cube, options));
    } else if (!frame.spaced || options.mode == DrawMode::point) {
      TRY(make_elements(scene, frame.cube, options));
    }
  }
  if (options.mode == DrawMode::voxel) {
    if (const int widest = gap_to_fill(scene.svo, scene.points); widest > 0)
      scene.filled = fill_gaps(scene.svo, scene.attributes, widest);
    if (worth_hiding(scene.svo)) scene.neighbors = leaf_neighbors(scene.svo);
  }
  if (lacks_scalar) scene.level = 0;  // with more layers, it is not grey
  if (options.mode == DrawMode::strip)
    make_strips(scene, tbb_executor(), record);
  else if (record != nullptr)
    record->reset();
  scene.svo_ms = watch.lap();
  return scene;
}

}  // namespace pointreel
