#pragma once

#include <vector>

#include "codec/octree/frame_header.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"

/// The octree codec. A frame is its sparse voxel octree, breadth-first with one byte for each
/// internal node (Slomp et al., Geometry Instancing, section VI-A), cut into layers of levels.
/// FORMAT.md, "Octree frames".
///
/// Trust: decoding takes hostile bytes; pointreel/codec.h says what it guarantees for them.
namespace pointreel {

/// The level at which a layer of a tree of this depth ends: 7 for the base (0), 9 for the middle
/// layer, and that of the leaves for the full layer, or in each case that of the leaves if it comes
/// first.
int last_level_of_layer(int layer, int depth);
/// The number of layers of a tree of this depth, 1 to 3.
int layer_count(int depth);

/// A decoded tree with the attributes of its leaves, in their order. They are empty if the frame or
/// its base layer does not have them; a finer layer without them inherits those of the layer
/// before.
struct OctreeFrame {
  FrameHeader header;
  Svo svo;  ///< ends where the given layers end
  std::vector<glm::u16vec3> colors;
  std::vector<glm::vec3> normals;
  NodeAttributes nodes;  ///< as DecodedFrame::attributes
  std::vector<ScalarField> scalars;
};
/// decode_octree without the cloud.
Result<OctreeFrame> decode_octree_tree(const std::vector<Chunks<ByteView>>& layers,
                                       const DecodeLimits& limits);

}  // namespace pointreel
