#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "codec/octree/coefficient_coder.h"
#include "codec/octree/int4.h"
#include "codec/octree/neighbor_prediction.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"
#include "pointreel/octree.h"

/// Colours or normals of a tree's nodes, lossy, layer by layer: transformed (raht.h), quantised,
/// and coded with adaptive binary contexts. FORMAT.md, "Transformed attributes".
///
/// A layer's chunk gives the nodes of all levels up to the layer's last their values, from those of
/// the levels that the layers before ended at; nothing of finer layers is needed for it. In a layer
/// the nodes of its last level weigh the same, so that weights follow from the tree that is there.
///
/// What three values mean, color_space.h and normal_space.h know. The first, luma of a colour, is
/// the one that contexts go by.
namespace pointreel {

/// How one layer is quantised.
struct CoefficientSteps {
  /// Quantisation steps of the first component's coefficients and of the two others', in 64/256 of
  /// a value; 1 to 65535. Those of an orthonormal transform of the layer's last level.
  std::uint16_t luma = 256, chroma = 256;
};

/// Steps of a whole frame for qualities below lossless, 1 to 99: OctreeOptions. Chroma is coarser
/// than luma by 2, as eyes are: the usual weights of 6 to 1 of their squared errors would make it
/// 2.4.
CoefficientSteps color_steps(int quality);
CoefficientSteps normal_steps(int quality);

/// Steps of a layer that ends at `nodes` nodes, of which each stands for leaves / nodes leaves, if
/// the whole frame is to be quantised by `steps`.
CoefficientSteps layer_steps(const CoefficientSteps& steps, std::uint32_t leaves,
                             std::uint32_t nodes);

/// Encodes the layers of one frame, base first.
class TransformEncoder {
 public:
  /// `leaves`: a value for each leaf. `layer_ends`: the last level of each layer. The tree and the
  /// leaves must outlive the encoder.
  TransformEncoder(const Svo& svo, const std::vector<Short4>& leaves,
                   const std::vector<int>& layer_ends);

  /// The next layer's bytes.
  Bytes encode_layer(const CoefficientSteps& steps);

 private:
  bool prediction_pays(int level);

  const Svo& svo_;
  const std::vector<Short4>& leaves_;
  std::vector<int> layer_ends_;
  std::size_t layer_ = 0;
  std::vector<Short4> means_;    ///< of the inner nodes, before quantisation
  std::vector<Short4> decoded_;  ///< of the inner nodes so far, as the decoder gets them
  Neighborhoods neighborhoods_;
  CoefficientContexts contexts_;
};

/// Decodes them. Memory: 8 bytes a node of the tree, and 172 a node of its finest level but two.
///
/// Trust: takes hostile bytes. What it allocates depends on the tree alone; it reads no byte beyond
/// the end; values are clamped, whatever the coefficients. Bytes that are too many or too few for
/// the tree are an error.
class TransformDecoder {
 public:
  explicit TransformDecoder(const Svo& svo);

  /// The nodes of levels up to `last_level`; the layers before have been decoded. With a lower
  /// `stop` only those up to that level: the bytes beyond are not looked at, and no layer can
  /// follow.
  Result<void> decode_layer(ByteView bytes, int last_level, int stop = kMaxDepth);

  /// Gives the nodes from the last decoded level on to `last_level` the values of their ancestors.
  void inherit(int last_level);

  /// Of the nodes of a level that has been decoded. (The fourth lane is of no use to the caller.)
  std::span<const Short4> values(int level) const;
  /// Of all nodes of the levels that have been decoded.
  std::span<const Short4> values() const;

 private:
  const Svo& svo_;
  int level_ = 0;
  std::unique_ptr<Short4[]> decoded_;  ///< of all nodes; not set from beyond level_ on
  Neighborhoods neighborhoods_;
  CoefficientContexts contexts_;
};

}  // namespace pointreel
