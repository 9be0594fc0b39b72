#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "codec/octree/coefficient_coder.h"
#include "codec/octree/color_prediction.h"
#include "codec/octree/int4.h"
#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/octree/svo.h"

/// Colours of a tree's nodes, lossy, layer by layer: transformed (raht.h), quantised, and coded
/// with adaptive binary contexts. FORMAT.md, "Transformed colours".
///
/// A layer's chunk gives the nodes of all levels up to the layer's last their colours, from those
/// of the levels that the layers before ended at; nothing of finer layers is needed for it. In a
/// layer the nodes of its last level weigh the same, so that weights follow from the tree that is
/// there.
namespace pointreel {

/// How one layer is quantised.
struct ColorSteps {
  /// Quantisation steps of coefficients, in 1/256 of an 8-bit value; 1 to 65535. Those of an
  /// orthonormal transform of the layer's last level.
  std::uint16_t luma = 256, chroma = 256;
};

/// Steps of a quality below lossless, 1 to 99: OctreeOptions::color_quality. Chroma is coarser, as
/// eyes are.
ColorSteps color_steps(int quality);

/// Steps of a layer that ends at `nodes` nodes, of which each stands for leaves / nodes leaves, if
/// the whole frame is to be quantised by `steps`.
ColorSteps layer_steps(const ColorSteps& steps, std::uint32_t leaves, std::uint32_t nodes);

/// Encodes the layers of one frame, base first.
class ColorEncoder {
 public:
  /// `leaf_colors`: one for each leaf. `layer_ends`: the last level of each layer.
  ColorEncoder(const Svo& svo, const std::vector<glm::u16vec3>& leaf_colors,
               const std::vector<int>& layer_ends);

  /// The next layer's bytes.
  Bytes encode_layer(const ColorSteps& steps);

 private:
  bool prediction_pays(int level);

  const Svo& svo_;
  std::vector<int> layer_ends_;
  std::size_t layer_ = 0;
  std::vector<Short4> source_;   ///< of all nodes, before quantisation
  std::vector<Short4> decoded_;  ///< of all nodes so far, as the decoder gets them
  Neighborhoods neighborhoods_;
  CoefficientContexts contexts_;
};

/// Decodes them. Memory: 8 bytes a node of the tree, and 112 a node of its finest level but two.
///
/// Trust: takes hostile bytes. What it allocates depends on the tree alone; it reads no byte beyond
/// the end; values are clamped, whatever the coefficients. Bytes that are too many or too few for
/// the tree are an error.
class ColorDecoder {
 public:
  explicit ColorDecoder(const Svo& svo);

  /// The nodes of levels up to `last_level`; the layers before have been decoded.
  Result<void> decode_layer(ByteView bytes, int last_level);

  /// Gives the nodes from the last decoded level on to `last_level` the colours of their ancestors.
  void inherit(int last_level);

  /// Colours of the nodes of a level that has been decoded.
  std::vector<glm::u16vec3> colors(int level) const;

 private:
  const Svo& svo_;
  int level_ = 0;
  std::vector<Short4> decoded_;
  Neighborhoods neighborhoods_;
  CoefficientContexts contexts_;
};

}  // namespace pointreel
