// Reads hostile .drc bytes as a user's file and as a frame's payload. libdraco itself is not
// instrumented, so crashes within it are found, but small reads beyond the input may not be.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "codec/draco/draco_payload.h"
#include "codec/draco/drc_reader.h"
#include "pointreel/draco.h"
#include "tests/fuzz/target.h"

namespace pointreel::fuzz::drc {

void check_sizes(const PointCloud& cloud, std::uint32_t most) {
  require(cloud.size() <= most);
  require(cloud.normals.empty() || cloud.normals.size() == cloud.size());
  require(cloud.colors.empty() || cloud.colors.size() == cloud.size());
}

}  // namespace pointreel::fuzz::drc

FUZZ_TARGET(drc) {
  const DecodeLimits limits{1u << 13, std::uint64_t{64} << 20};
  if (auto cloud = read_drc(input, limits)) {
    check_sizes(*cloud, limits.max_points);
    sanitize(*cloud);
    if (!cloud->empty()) require(std::isfinite(bounds(*cloud).extent().x));
  }

  const Cube cube{{1.0, 2.0, 3.0}, 4.0};
  const int bits = DracoOptions{}.position_bits;
  if (const auto cloud = decode_draco_payload(input, cube, bits, limits)) {
    check_sizes(*cloud, limits.max_points);
    if (cloud->empty()) return;
    const Box box = bounds(*cloud);
    for (int axis = 0; axis < 3; ++axis) {
      require(box.min[axis] >= cube.origin[axis] - 1e-6);
      require(box.max[axis] <= cube.origin[axis] + cube.edge + 1e-6);
    }
    // A decoded cloud must encode again, with the same number of points.
    for (const auto method : {DracoMethod::kd_tree, DracoMethod::sequential}) {
      DracoOptions options;
      options.method = method;
      const auto again = encode_draco_payload(*cloud, cube, options, true, true);
      require(again.has_value());
      const auto decoded = decode_draco_payload(*again, cube, bits, limits);
      require(decoded.has_value() && decoded->size() == cloud->size());
    }
  }
}
