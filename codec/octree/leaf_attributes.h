#pragma once

#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "pointreel/bytes.h"
#include "pointreel/octree.h"

/// The colours and normals of the nodes at a layer's last level, as bytes. Each value is stored as
/// the difference from that of the node's ancestor at the last level of the layer before, so that
/// attributes refine with the layers. Bytes are planar: one component of all nodes, then the next.
/// FORMAT.md, "Attributes stored exactly". No amount of memory depends on untrusted numbers.
namespace pointreel {

/// A node's stored attribute: one integer for each component, 8 or 16 bits wide.
using Codes = std::vector<glm::u16vec3>;

/// The components are green, red - green and blue - green, modulo 2^bits.
Codes color_codes(const glm::u16vec3* colors, std::size_t count, int bits);
std::vector<glm::u16vec3> colors_from_codes(const Codes& codes, int bits);

/// Maps normals to an octahedron, with 8 bits for each of two components; the third is zero. 255,
/// 255 stands for an unknown normal. The error is below one degree.
Codes normal_codes(const glm::i16vec3* normals, std::size_t count);
std::vector<glm::vec3> normals_from_codes(const Codes& codes);

/// Gives each node of `to_level` the code of its ancestor at `from_level`.
Codes inherit(const Svo& svo, const Codes& codes, int from_level, int to_level);

/// The number of stored components of an attribute, and of bits in each.
struct CodeShape {
  int components = 3;
  int bits = 8;

  std::size_t bytes(std::size_t count) const {
    return count * static_cast<std::size_t>(components * bits / 8);
  }
};

/// Stores `codes - predicted`, modulo 2^bits, in planar order; add_differences undoes it. `bytes`
/// has the right size.
Bytes code_differences(const Codes& codes, const Codes& predicted, const CodeShape& shape);
Codes add_differences(ByteView bytes, const Codes& predicted, const CodeShape& shape);

}  // namespace pointreel
