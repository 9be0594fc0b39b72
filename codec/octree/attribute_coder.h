#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "codec/octree/attribute_value.h"
#include "codec/octree/coefficient_coder.h"
#include "codec/octree/frame_structure.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"
#include "pointreel/octree.h"

/// Codes the colours or normals of a tree's nodes layer by layer: they are predicted
/// (level_prediction.h), transformed (raht.h), quantised, and coded with adaptive alphabets. Exact
/// layers are not quantised, and undone in integers. FORMAT.md, "Transformed attributes".
///
/// The chunk of a layer gives values to the nodes of all its levels, starting from those of the
/// level at which the layer before ended. It needs nothing of finer layers: the nodes of a layer's
/// last level all weigh the same, so that weights depend only on the tree up to there. Each level
/// is coded in two passes: the first gives base values and contexts to all its nodes, the second
/// reads coefficients and adds what they stand for.
///
/// An attribute consists of three values, whose meaning is defined in color_space.h and
/// normal_space.h. Contexts depend mostly on the first, which is the luma of a colour.
namespace pointreel {

enum class AttributeKind : std::uint8_t { colors, normals };

/// How a layer is quantised.
struct CoefficientSteps {
  /// The quantisation steps of the first component and of the other two, in units of 64/256 of a
  /// value, 1 to 65535. They apply to the coefficients of an orthonormal transform of the layer's
  /// last level. Those of normals are turned into tangent frames first: the first step is that of
  /// both tangents, and the other one that of the direction of the normal.
  std::uint16_t luma = 256, chroma = 256;
};

/// What exact layers state as their steps. It selects contexts only.
inline constexpr CoefficientSteps kExactSteps{32, 32};

/// The steps of a whole frame for a quality from 1 to 99 (OctreeOptions). Chroma is quantised twice
/// as coarsely as luma. The usual weights of their squared errors, 6 to 1, make 2.4 slightly
/// better, but then dark things show blotches from nearby.
CoefficientSteps color_steps(int quality);
/// The length of a normal is not used, so that its direction is quantised twice as coarsely as the
/// tangents.
CoefficientSteps normal_steps(int quality);

/// The steps of a layer whose last level has `nodes` nodes, in a frame with these steps. Each of
/// the nodes stands for leaves / nodes leaves.
CoefficientSteps layer_steps(const CoefficientSteps& steps, std::uint32_t leaves,
                             std::uint32_t nodes);

/// Encodes the layers of one frame, base first.
class TransformEncoder {
 public:
  /// `leaves`: the value of each leaf. The structure and the leaves must outlive the encoder.
  /// `exact`: keep the leaves as they are; no two of their values may then differ by more than
  /// 2^15, and they are not normals.
  TransformEncoder(const FrameStructure& structure, AttributeKind kind,
                   const std::vector<Short4>& leaves, bool exact = false);

  /// Encodes the next layer. The steps of an exact one are kExactSteps.
  Bytes encode_layer(const CoefficientSteps& steps);

 private:
  const FrameStructure& structure_;
  AttributeKind kind_;
  const std::vector<Short4>& leaves_;
  bool exact_;
  std::size_t layer_ = 0;
  std::vector<Short4> means_;    ///< the values of the inner nodes before quantisation
  std::vector<Short4> decoded_;  ///< the values that a decoder has, so far
  std::vector<Short4> planes_;
  CoefficientContexts contexts_;
};

/// Decodes the layers of a frame. Takes 9 bytes for each node of the tree, and the planes of the
/// structure's largest level.
///
/// Trust: the bytes may be hostile. Memory depends only on the tree, no byte beyond the end is
/// read, and values are clamped whatever the coefficients. Too many or too few bytes for the tree
/// are an error.
class TransformDecoder {
 public:
  /// The levels of a layer from `first_level` on that its bytes say are predicted. They must be
  /// ordered in the structure of the layer's decoder.
  static LevelSet predicted_levels(ByteView bytes, int first_level);

  TransformDecoder(const FrameStructure& structure, AttributeKind kind);

  /// Decodes a layer, whose nodes end at `last_level`. The layers before it must have been decoded.
  /// A lower `stop` decodes only up to that level: the other bytes are ignored, and no further
  /// layer can be decoded.
  Result<void> decode_layer(ByteView bytes, int last_level, int stop = kMaxDepth);

  /// Gives the nodes below the last decoded level, up to `last_level`, the values of their
  /// ancestors.
  void inherit(int last_level);

  /// Whether the decoded layers are exact.
  bool exact() const { return exact_; }

  /// The values of the nodes of a decoded level. Only the first three lanes are meaningful.
  std::span<const Short4> values(int level) const;
  /// The values of all nodes of the decoded levels.
  std::span<const Short4> values() const;

 private:
  const FrameStructure& structure_;
  AttributeKind kind_;
  int level_ = 0;
  bool exact_ = false;
  std::unique_ptr<Short4[]> decoded_;  ///< for all nodes; uninitialised below level_
  std::vector<Short4> planes_;
  CoefficientContexts contexts_;
};

}  // namespace pointreel
