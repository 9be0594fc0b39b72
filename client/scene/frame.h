#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <glm/glm.hpp>

#include "client/scene/draw_mode.h"
#include "client/scene/gap_filling.h"
#include "client/scene/leaf_neighbors.h"
#include "pointreel/cloud.h"
#include "pointreel/octree.h"

namespace pointreel {

/// The level of a frame to which nothing could be added by fetching or preparing more of it.
inline constexpr int kWholeFrame = kMaxDepth;

/// A decoded frame, ready to draw. Immutable once the pipeline has made it.
///
/// Either a tree with attributes of its nodes, of which a cut is drawn, or a cloud, whose points
/// are drawn as surfels or points.
struct SceneFrame {
  std::uint32_t index = 0;    ///< in the reel
  std::uint64_t time_us = 0;  ///< from the reel's start
  /// What surfels and points draw where it is not empty; else they draw the tree, as voxels do.
  PointCloud cloud;
  Svo svo;
  // Of the cloud and of the tree's nodes alike: colours are present only if the source has them,
  // normals in surfel mode and where there are no colours (estimated from neighbours where the
  // source has none; zero where unknown), radii in surfel mode.
  NodeAttributes attributes;
  std::vector<float> radii;  ///< of the nodes
  /// Of the nodes, in voxel mode where there were gaps between voxels (gap_filling.h); else empty.
  FilledNodes filled;
  /// Of the leaves, in voxel mode where enough voxels hide others (worth_hiding); else empty.
  std::vector<NeighborBits> neighbors;
  /// The normals were estimated from neighbours: their line is right, their sign may be wrong, so
  /// the side that they point to is no reason to cull.
  bool normals_estimated = false;

  /// The finest level of the tree that would be drawn if everything was in it. A cut that ends
  /// below it needs the frame to be fetched or prepared again.
  int level = kWholeFrame;
  std::uint32_t points = 0;  ///< that the source had, as far as the frame tells
  std::uint32_t layers = 0;  ///< that it was made of; 0: a file
  /// What it took to make, in the order of the stages; normals: where estimated.
  double fetch_ms = 0.0, decode_ms = 0.0, normals_ms = 0.0, svo_ms = 0.0;
};

/// Bytes that it takes, of what grows with its points.
std::uint64_t memory_of(const SceneFrame& frame);

/// A frame and where it stands in the world.
struct PlacedFrame {
  std::shared_ptr<const SceneFrame> frame;  ///< null: nothing
  glm::dvec3 place{0.0};                    ///< is added to its coordinates

  bool operator==(const PlacedFrame&) const = default;
};

/// What is seen at a time: a frame of each source.
using Scene = std::vector<PlacedFrame>;

}  // namespace pointreel
