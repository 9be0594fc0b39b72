#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/scene/frame.h"
#include "client/source/fetched.h"
#include "pointreel/codec.h"
#include "pointreel/geometry.h"
#include "pointreel/package.h"

namespace pointreel {

/// Which scalar field is shown in place of colours.
struct ScalarChoice {
  std::string field;                ///< its name; empty: none
  std::optional<glm::dvec2> range;  ///< values at the ends of the ramp; else those of the source

  bool operator==(const ScalarChoice&) const = default;
};

/// How frames are made ready to draw.
struct PrepareOptions {
  DrawMode mode = DrawMode::surfel;
  /// >= 0, of the tree that voxels are drawn from (DepthRule::delta). Far above the 0.05 of Slomp
  /// et al., which gives nearly every point a voxel of its own, with gaps between them wherever
  /// points are not on a grid; below 0.75, at which points that are on one would lose a level.
  double delta = 0.72;
  int level = kWholeFrame;    ///< no finer level of detail is prepared
  ScalarChoice scalar = {};   ///< needs all layers, and `level` does not matter
  bool show_normals = false;  ///< they are prepared in every mode, because they are what is shown
  float pixel_size = 1.0f;    ///< DrawOptions::pixel_size, which decides what level a camera sees
  std::uint32_t layers = kAllLayers;  ///< no more are fetched or decoded, however near the camera
  std::uint64_t max_memory = kFrameMemory;  ///< DecodeLimits::max_memory

  bool operator==(const PrepareOptions&) const = default;
};

/// What a source says of a frame, besides its bytes.
struct FrameInfo {
  std::uint32_t index = 0;    ///< in the reel, or its number in the stream
  std::uint64_t time_us = 0;  ///< from the reel's start, or when it was captured, as Unix time
  Cube cube = {};             ///< of a tree that is built of a cloud without one of its own
  std::vector<ScalarRange> scalars = {};  ///< ReelHead::scalars
  bool normals_estimated = false;         ///< Manifest::normals_estimated
};
/// index < manifest.frame_count().
FrameInfo frame_info(const Manifest& manifest, std::uint32_t index);

/// Makes a fetched frame ready to draw: decodes it, and derives what the mode needs and the source
/// does not have. Of `options`, pixel_size and layers do not matter here.
///
/// An octree frame stays the tree that it is, down to `options.level`, with the attributes of its
/// nodes, and without positions. For voxels it is cut off where a coarser level already satisfies
/// delta, by the count of the source's points.
///
/// Surfels and points draw any other frame as a cloud, unless so many of its points fall together
/// at `options.level` that building a tree of that depth pays, or it is a large cloud of voxels,
/// which becomes the tree of these voxels that its package would have. Radii of points then become
/// radii of leaves. Voxels draw a tree that is built to satisfy delta, or to `options.level`. Trees
/// are built in `info.cube`, but those of files in the frame's bounding cube, and those of large
/// clouds of voxels in a cube whose cells these are. Gaps between voxels are filled
/// (gap_filling.h).
///
/// Normals that are needed but absent are estimated from neighbours. Radii that are absent are made
/// in surfel mode, from the tree (tree_radii.h, node_radii.h).
///
/// Strips are made of surfels (strip_frame.h). If there is a place for their record, it is used,
/// and replaced by that of this frame, or in other modes by null.
///
/// A scalar field that is chosen becomes the colours (scalar_colors.h). Where it is not known, also
/// because it has not come yet, they are grey.
///
/// Fills decode_ms (bytes to cloud or tree), normals_ms (their estimation) and svo_ms (tree,
/// attributes and radii), and level, points and layers as far as they are known. The bytes may be
/// hostile. Large frames are decoded, and their trees built, by several threads of the caller's TBB
/// arena, if it has idle ones. From the first time that `stopped` says yes, it fails soon with
/// ErrorCode::cancelled.
Result<SceneFrame> prepare_frame(const FetchedFrame& fetched, const FrameInfo& info,
                                 const PrepareOptions& options,
                                 const std::function<bool()>& stopped = {},
                                 std::shared_ptr<const StripRecord>* record = nullptr);

/// DecodeLimits::spacing for frames that are prepared in this way: the edge of a cell of
/// `options.level` in `cube`, where it does not matter that points leave gaps between cells.
double spacing_for(const PrepareOptions& options, const Cube& cube);

/// The same for a frame that is decoded, with nothing in it but what `options` asks for. Layers and
/// decode_ms are not filled.
Result<SceneFrame> prepare_decoded(DecodedFrame frame, const FrameInfo& info,
                                   const PrepareOptions& options,
                                   const std::function<bool()>& stopped = {},
                                   std::shared_ptr<const StripRecord>* record = nullptr);

}  // namespace pointreel
