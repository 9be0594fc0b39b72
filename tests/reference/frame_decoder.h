#pragma once

#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "pointreel/bytes.h"
#include "pointreel/draco.h"
#include "pointreel/error.h"
#include "tests/reference/context_decoder.h"

namespace pointreel::reference {

/// The chunks of one layer; empty where they are missing.
struct FrameLayer {
  ByteView geometry, colors, normals;
};

struct Frame {
  int depth = 0;                        ///< of the layers that are there
  std::vector<glm::uvec3> cells;        ///< leaves, in Morton order
  std::vector<glm::u16vec3> colors;     ///< of each leaf, 65535 for 1; or none
  std::vector<glm::dvec3> normals;      ///< of each leaf, 0 where unknown; or none
  glm::dvec3 corner = glm::dvec3(0.0);  ///< of the cube
  double edge = 0.0;
};

/// Decodes an octree frame, or a prefix of its layers, as codec/FORMAT.md tells it, in the plainest
/// way. Knows nothing of the codec's code. `tables` are tables 1. Refuses whatever the description
/// tells a reader to refuse; memory and time are bounded for small frames only.
Result<Frame> decode_frame(const std::vector<FrameLayer>& layers, const Tables& tables);

}  // namespace pointreel::reference
