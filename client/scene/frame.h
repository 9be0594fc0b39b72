#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "client/scene/draw_mode.h"
#include "client/scene/gap_filling.h"
#include "client/scene/leaf_neighbors.h"
#include "client/strips/strips.h"
#include "pointreel/cloud.h"
#include "pointreel/octree.h"
#include "pointreel/package.h"

namespace pointreel {

/// The level of a frame that fetching or preparing more of it would not make finer.
inline constexpr int kWholeFrame = kMaxDepth;

/// Where the points of a frame are, as far as it was decoded.
struct FrameBoxes {
  Box all;            ///< of all points, or of the cells that hold them
  Box main;           ///< without a few points far away; empty if they coincide: it tells no size
  bool rough = true;  ///< a frame in more detail may tell something else
};

/// The scalar field that the colours of a frame stand for.
struct ShownScalar {
  ScalarRange range;        ///< from the first to the last colour
  std::vector<int> labels;  ///< that the frame has, if they are labels
};

/// A decoded frame, ready to draw. Immutable once the pipeline has made it.
///
/// Either a tree with attributes of its nodes, of which a cut is drawn, or a cloud, whose points
/// are drawn as surfels or points.
struct SceneFrame {
  std::uint32_t index = 0;    ///< in the reel
  std::uint64_t time_us = 0;  ///< from the reel's start
  /// Surfels and points draw the cloud if it is not empty, else the tree, as voxels do.
  PointCloud cloud;
  /// In strip mode, the surface between the points of the cloud; else empty. There is no tree then.
  SurfelStrips strips;
  Svo svo;
  // The cloud and the tree's nodes have the same attributes: colours only if the source has them;
  // normals in surfel mode, where there are no colours, and where they are shown (estimated from
  // neighbours if the source has none; zero where unknown); radii in surfel mode.
  NodeAttributes attributes;
  std::optional<ShownScalar> scalar;  ///< in place of the source's colours
  std::vector<float> radii;           ///< of the nodes
  /// From the centres of the leaves along their normals to the surface (leaf_heights), in surfel
  /// mode, and if there are not too many leaves; else empty.
  std::vector<float> heights;
  /// Which nodes fill gaps between voxels (gap_filling.h); empty if none do.
  FilledNodes filled;
  /// One entry for each leaf, in voxel mode if enough voxels hide others (worth_hiding); else
  /// empty.
  std::vector<NeighborBits> neighbors;
  /// The typical distance between neighbouring points, in point mode (point_spacing.h); 0 if it is
  /// not known.
  float spacing = 0.0f;
  /// The normals were estimated from neighbours. Their line is right but their sign may be wrong,
  /// so that surfels must not be culled by the side that they face.
  bool normals_estimated = false;

  /// The finest level of the tree that can be drawn from this frame. A view that shows finer levels
  /// needs the frame to be fetched or prepared again.
  int level = kWholeFrame;
  FrameBoxes boxes;
  std::uint32_t points = 0;  ///< of the source, as far as the frame tells
  std::uint32_t layers = 0;  ///< that the frame was made of; 0 for a file
  /// How long each stage took, in their order; normals only if they were estimated. Making strips
  /// is part of the last.
  double fetch_ms = 0.0, decode_ms = 0.0, normals_ms = 0.0, svo_ms = 0.0;
};

/// The points of the cloud or, if there is none, the leaves of the tree where surfels draw them.
PointCloud surfels_of(const SceneFrame& frame);

/// The bytes that a frame takes in memory.
std::uint64_t memory_of(const SceneFrame& frame);

/// A frame and its place in the world.
struct PlacedFrame {
  std::shared_ptr<const SceneFrame> frame;  ///< null: nothing
  glm::dvec3 place{0.0};                    ///< added to its coordinates

  bool operator==(const PlacedFrame&) const = default;
};

/// What is seen at one time: a frame of each source.
using Scene = std::vector<PlacedFrame>;

}  // namespace pointreel
