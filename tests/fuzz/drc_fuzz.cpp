// Reads hostile .drc bytes as a user's file and as a frame's payload. libdraco itself is not
// instrumented, so crashes within it are found, but small reads beyond the input may not be.
//
//   drc_fuzz -max_len=4096 CORPUS_COPY tests/fuzz/corpus/drc

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "codec/draco/draco_payload.h"
#include "codec/draco/drc_reader.h"
#include "pointreel/draco.h"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

void check_sizes(const pointreel::PointCloud& cloud, std::uint32_t most) {
  require(cloud.size() <= most);
  require(cloud.normals.empty() || cloud.normals.size() == cloud.size());
  require(cloud.colors.empty() || cloud.colors.size() == cloud.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const pointreel::ByteView bytes(data, size);
  const pointreel::DecodeLimits limits{1u << 13, std::uint64_t{64} << 20};
  if (auto cloud = pointreel::read_drc(bytes, limits)) {
    check_sizes(*cloud, limits.max_points);
    pointreel::sanitize(*cloud);
    if (!cloud->empty()) require(std::isfinite(pointreel::bounds(*cloud).extent().x));
  }

  const pointreel::Cube cube{{1.0, 2.0, 3.0}, 4.0};
  const int bits = pointreel::DracoOptions{}.position_bits;
  if (const auto cloud = pointreel::decode_draco_payload(bytes, cube, bits, limits)) {
    check_sizes(*cloud, limits.max_points);
    if (cloud->empty()) return 0;
    const pointreel::Box box = pointreel::bounds(*cloud);
    for (int axis = 0; axis < 3; ++axis) {
      require(box.min[axis] >= cube.origin[axis] - 1e-6);
      require(box.max[axis] <= cube.origin[axis] + cube.edge + 1e-6);
    }
    // A decoded cloud must encode again, with the same number of points.
    for (const auto method :
         {pointreel::DracoMethod::kd_tree, pointreel::DracoMethod::sequential}) {
      pointreel::DracoOptions options;
      options.method = method;
      const auto again = pointreel::encode_draco_payload(*cloud, cube, options, true, true);
      require(again.has_value());
      const auto decoded = pointreel::decode_draco_payload(*again, cube, bits, limits);
      require(decoded.has_value() && decoded->size() == cloud->size());
    }
  }
  return 0;
}
