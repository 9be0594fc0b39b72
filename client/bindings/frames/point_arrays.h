#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "codec/package/encoding_options.h"
#include "pointreel/cloud.h"
#include "pointreel/draco.h"
#include "pointreel/error.h"

namespace pointreel {

/// Points in somebody else's memory, three numbers for each. Of the positions, either are given.
struct PointArrays {
  std::size_t count = 0;
  const float* positions = nullptr;         ///< relative to `origin`
  const double* world_positions = nullptr;  ///< an origin is found among them
  glm::dvec3 origin{0.0};
  // Null where the points do not have the attribute.
  const std::uint8_t* colors_8 = nullptr;
  const std::uint16_t* colors_16 = nullptr;
  const float* normals = nullptr;
  /// A scalar field, one number for each point.
  struct Scalar {
    std::string name;
    const float* values = nullptr;
  };
  std::vector<Scalar> scalars;
};

/// Copies them. `argument` where arrays are missing or given twice, or a scalar field's name is
/// none (cloud.h); `limit` for too many points. The values may be anything: points without a finite
/// position, or one that floats cannot hold, are left out (`sanitize`).
Result<PointCloud> cloud_of(const PointArrays& arrays);

/// The colour as 8 bits, rounded.
inline glm::u8vec3 to_8_bits(const glm::u16vec3& color) {
  return glm::u8vec3((glm::uvec3(color) + 128u) / 257u);
}

/// Encodes a cloud in the grid that fits it. Errors: as encode_frame, and `limit` if some points
/// lie so far away that the others would collapse.
Result<EncodedFrame> encode_points(const PointCloud& cloud, const EncodingOptions& options);

}  // namespace pointreel
