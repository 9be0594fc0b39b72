#pragma once

#include <cstdint>

#include "common/cloud/point_cloud.h"
#include "common/octree/svo.h"

namespace pointreel {

/// What is drawn for each element of a frame. It decides what the pipeline prepares: surfels and
/// points need the cloud, voxels the tree and its mean attributes.
enum class DrawMode { surfel, voxel, point };

/// A decoded frame, ready to draw. Immutable once the pipeline has made it.
struct SceneFrame {
  std::uint32_t index = 0;    ///< in the reel
  std::uint64_t time_us = 0;  ///< from the reel's start
  /// What surfels and points draw. Colours are present only if the source has them. Normals are
  /// present in surfel mode and where there are no colours (estimated from neighbours where the
  /// source has none; zero where unknown); radii in surfel mode.
  PointCloud cloud;
  /// The normals were estimated from neighbours: their line is right, their sign may be wrong, so
  /// the side that they point to is no reason to cull.
  bool normals_estimated = false;
  /// Rebuilt for every frame; what voxels draw. Node attributes are filled in voxel mode only.
  Svo svo;
  NodeAttributes attributes;

  std::uint64_t fetched_bytes = 0;  ///< that it was made of
  /// What it took to make, in the order of the stages; normals: where estimated.
  double fetch_ms = 0.0, decode_ms = 0.0, normals_ms = 0.0, svo_ms = 0.0;
};

}  // namespace pointreel
