#pragma once

#include <vector>

#include "codec/frame_header.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"

/// The octree codec: a frame is its sparse voxel octree, breadth-first, one byte for each internal
/// node (paper 2, section VI-A), cut into layers of levels. FORMAT.md, "Octree frames".
///
/// Trust: decoding takes hostile bytes. Memory is bounded before it is taken: by the size of the
/// payload (a zstd payload may expand 1024 times plus 64 KiB, no more), by the header's point count
/// and by DecodeLimits. Masks that are no tree, sizes that disagree with the masks and counts that
/// disagree with the header are errors. Decoding gives the encoder's voxels exactly or an error.
namespace pointreel {

/// The level at which layer `layer` of a tree of this depth ends: base 7, middle 9, full the
/// leaves.
int last_level_of_layer(int layer, int depth);
/// How many layers a tree of this depth has: 1 to 3.
int layer_count(int depth);

/// A decoded tree with the attributes of its leaves, in their order; empty where they were not sent
/// or not fetched. Attributes of a layer that was fetched without them are those of the layer
/// above.
struct OctreeFrame {
  FrameHeader header;
  Svo svo;  ///< as deep as the layers that were given
  std::vector<glm::u16vec3> colors;
  std::vector<glm::vec3> normals;
  NodeAttributes nodes;  ///< as DecodedFrame::attributes
};
Result<OctreeFrame> decode_octree_tree(const std::vector<Chunks<ByteView>>& layers,
                                       const DecodeLimits& limits);

}  // namespace pointreel
