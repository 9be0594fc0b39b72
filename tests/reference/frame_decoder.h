#pragma once

#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/error.h"
#include "tests/reference/context_decoder.h"

namespace pointreel::reference {

struct Scalar {
  std::string name;
  std::vector<float> values;  ///< of each leaf, NaN where unknown
};

struct Frame {
  int depth = 0;                     ///< of the given layers
  std::vector<glm::uvec3> cells;     ///< the leaves, in Morton order
  std::vector<glm::u16vec3> colors;  ///< of each leaf, where 65535 is full intensity; or empty
  std::vector<glm::dvec3> normals;   ///< of each leaf, 0 where unknown; or empty
  std::vector<Scalar> scalars;
  glm::dvec3 corner = glm::dvec3(0.0);  ///< of the cube
  double edge = 0.0;
};

/// Decodes an octree frame, or a prefix of its layers, as codec/FORMAT.md describes it, in the
/// simplest way and without any code of the codec. Refuses everything that the description tells a
/// reader to refuse. `tables`: tables 1. For small frames only, since memory and time are not
/// bounded.
Result<Frame> decode_frame(const std::vector<Chunks<ByteView>>& layers, const Tables& tables);

}  // namespace pointreel::reference
