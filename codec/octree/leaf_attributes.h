#pragma once

#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "pointreel/bytes.h"
#include "pointreel/octree.h"

/// Colours and normals of the nodes at a layer's last level, as bytes. Each value is stored as its
/// difference from the value of the node's ancestor at the last level of the layer before, so that
/// attributes refine with the layers. Bytes are planar: one component of all nodes, then the next.
/// FORMAT.md, "Attributes". Nothing here allocates by a number from outside.
namespace pointreel {

/// A node's stored attribute: one integer for each component, 8 or 16 bits wide.
using Codes = std::vector<glm::u16vec3>;

/// Components green, red - green, blue - green, modulo 2^bits.
Codes color_codes(const glm::u16vec3* colors, std::size_t count, int bits);
std::vector<glm::u16vec3> colors_from_codes(const Codes& codes, int bits);

/// Octahedral map, 8 bits a component (third component unused, zero); 255, 255 for no normal. The
/// error is below one degree.
Codes normal_codes(const glm::i16vec3* normals, std::size_t count);
std::vector<glm::vec3> normals_from_codes(const Codes& codes);

/// Gives each node of `to_level` its ancestor's code of `from_level`.
Codes inherit(const Svo& svo, const Codes& codes, int from_level, int to_level);

/// What is stored of one kind of attribute: how many components, how many bits each.
struct CodeShape {
  int components = 3;
  int bits = 8;

  std::size_t bytes(std::size_t count) const {
    return count * static_cast<std::size_t>(components * bits / 8);
  }
};

/// Differences `codes - predicted`, modulo 2^bits, planar; and back (`bytes` has the right size).
Bytes code_differences(const Codes& codes, const Codes& predicted, const CodeShape& shape);
Codes add_differences(ByteView bytes, const Codes& predicted, const CodeShape& shape);

}  // namespace pointreel
