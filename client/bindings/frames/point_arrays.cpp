#include "client/bindings/frames/point_arrays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "codec/core/scalar_fields.h"
#include "codec/files/middle_half.h"
#include "codec/package/collapse.h"
#include "codec/package/frames_grid.h"
#include "codec/package/strays.h"
#include "common/base/out_of_memory.h"
#include "common/base/spread.h"
#include "common/base/try.h"
#include "common/threads/tbb_executor.h"
#include "pointreel/codec.h"

namespace pointreel {
namespace {

/// Copies `count` vectors that are stored without gaps.
template <class Vector, class Number>
std::vector<Vector> vectors(const Number* numbers, std::size_t count) {
  static_assert(sizeof(Vector) == 3 * sizeof(Number));
  std::vector<Vector> result(count);
  if (count > 0) std::memcpy(static_cast<void*>(result.data()), numbers, count * sizeof(Vector));
  return result;
}

template <class Vector>
bool is_finite(const Vector& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

glm::dvec3 world_position(const PointArrays& arrays, std::size_t i) {
  const double* at = arrays.world_positions + 3 * i;
  return {at[0], at[1], at[2]};
}

/// MiddleHalf::origin of some of the points that floats can hold: points that are anywhere else do
/// not change it.
glm::dvec3 origin_of(const PointArrays& arrays) {
  constexpr std::size_t kSamples = 1024;
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < arrays.count; ++i)
    if (is_finite(glm::vec3(world_position(arrays, i)))) usable.push_back(i);
  if (usable.empty()) return glm::dvec3(0.0);
  const std::size_t samples = std::min(kSamples, usable.size());
  std::array<std::vector<double>, 3> values;
  for (std::size_t i = 0; i < samples; ++i) {
    const glm::dvec3 at = world_position(arrays, usable[spread_index(i, samples, usable.size())]);
    for (int axis = 0; axis < 3; ++axis) values[static_cast<std::size_t>(axis)].push_back(at[axis]);
  }
  return middle_half(values).origin();
}

void take_world_positions(PointCloud& cloud, const PointArrays& arrays) {
  cloud.origin = origin_of(arrays);
  cloud.positions.reserve(arrays.count);
  for (std::size_t i = 0; i < arrays.count; ++i)
    cloud.positions.emplace_back(world_position(arrays, i) - cloud.origin);
}

}  // namespace

Result<PointCloud> cloud_of(const PointArrays& arrays) {
  if ((arrays.positions != nullptr) == (arrays.world_positions != nullptr) && arrays.count > 0)
    return fail(ErrorCode::argument, "either float or double positions are needed");
  if (arrays.colors_8 != nullptr && arrays.colors_16 != nullptr)
    return fail(ErrorCode::argument, "colours have either 8 or 16 bits");
  if (arrays.count > DecodeLimits{}.max_points)
    return fail(ErrorCode::limit, "a frame has at most 2^26 points");
  if (!is_finite(arrays.origin)) return fail(ErrorCode::argument, "the origin is not finite");
  return or_out_of_memory([&]() -> Result<PointCloud> {
    PointCloud cloud;
    if (arrays.positions != nullptr) {
      cloud.origin = arrays.origin;
      cloud.positions = vectors<glm::vec3>(arrays.positions, arrays.count);
    } else {
      take_world_positions(cloud, arrays);
    }
    if (arrays.normals != nullptr) cloud.normals = vectors<glm::vec3>(arrays.normals, arrays.count);
    if (arrays.colors_16 != nullptr)
      cloud.colors = vectors<glm::u16vec3>(arrays.colors_16, arrays.count);
    if (arrays.colors_8 != nullptr) {
      cloud.colors.reserve(arrays.count);
      for (std::size_t i = 0; i < arrays.count; ++i) {
        const std::uint8_t* at = arrays.colors_8 + 3 * i;
        cloud.colors.emplace_back(257 * at[0], 257 * at[1], 257 * at[2]);
      }
    }
    for (const PointArrays::Scalar& scalar : arrays.scalars) {
      if (scalar.values == nullptr && arrays.count > 0)
        return fail(ErrorCode::argument, "a scalar field has no values");
      cloud.scalars.push_back({scalar.name, {scalar.values, scalar.values + arrays.count}});
    }
    TRY(check_scalars(cloud));
    sanitize(cloud);
    return cloud;
  });
}

Result<EncodedFrame> encode_points(const PointCloud& cloud, const EncodingOptions& options) {
  return or_out_of_memory([&]() -> Result<EncodedFrame> {
    EncodingOptions parallel = options;
    parallel.encode.executor = tbb_executor();
    const std::string strays = strays_text(cloud);
    auto encoded = [&]() -> Result<EncodedFrame> {
      const FrameExtent extent = extent_of(cloud);
      const Grid grid = TRY(grid_for_frames({&extent, 1}, parallel, [&](std::size_t) {
        return Result<std::shared_ptr<const PointCloud>>(
            std::shared_ptr<const PointCloud>(std::shared_ptr<void>(), &cloud));
      }));
      EncodedFrame frame = TRY(encode_frame(cloud, grid.cube, grid.encode));
      if (!options.voxel) TRY(check_collapse(frame, cloud, grid, !strays.empty()));
      return frame;
    }();
    if (!encoded) return tl::unexpected(blame(strays, encoded.error()));
    return encoded;
  });
}

}  // namespace pointreel
