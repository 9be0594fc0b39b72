#include "codec/formats/sweep.h"

#include <algorithm>
#include <cmath>

#include "codec/formats/records.h"
#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::size_t kLooked = 4096;  // points
/// In metres. The best scanners see 500.
constexpr float kFurthest = 1e5f;

float at(ByteView bytes, std::size_t index) {
  return load_number<float>(bytes.data() + index * sizeof(float));
}

bool fifth_is_ring(ByteView begin) {
  const std::size_t points = begin.size() / (5 * sizeof(float));
  bool varies = false;
  for (std::size_t i = 0; i < points; ++i) {
    const float ring = at(begin, 5 * i + 4);
    if (!(ring >= 0.0f && ring < 256.0f) || ring != std::floor(ring)) return false;
    varies |= ring != at(begin, 4);
  }
  return varies;
}

bool look_measured(ByteView begin, std::size_t floats) {
  const std::size_t points = begin.size() / (floats * sizeof(float));
  std::size_t good = 0;
  for (std::size_t i = 0; i < points; ++i) {
    const float x = at(begin, floats * i), y = at(begin, floats * i + 1),
                z = at(begin, floats * i + 2);
    // False for NaN.
    good += std::abs(x) < kFurthest && std::abs(y) < kFurthest && std::abs(z) < kFurthest &&
            (x == 0.0f || std::abs(x) > 1e-12f);
  }
  return good * 2 >= points;
}

}  // namespace

Result<PointCloud> read_sweep(const ByteSource& source, std::size_t floats) {
  Bytes room;
  const ByteView begin = TRY(source.view(0, kLooked * 5 * sizeof(float), room));
  const bool four = source.size() % 16 == 0, five = source.size() % 20 == 0;
  if (floats == 0) floats = five && (!four || fifth_is_ring(begin)) ? 5 : 4;
  const std::size_t size = floats * sizeof(float);
  if (source.size() % size != 0) {
    return fail(concat("has ", source.size(), " bytes, which is no number of points of ", floats,
                       " floats, as in a sweep of ", floats == 4 ? "KITTI" : "nuScenes"));
  }
  if (!look_measured(begin, floats)) {
    return fail(concat("is no sweep of KITTI or nuScenes: most of its first numbers, read as ",
                       floats, " floats a point, are no coordinates"));
  }
  RecordLayout layout;
  for (std::size_t i = 0; i < 3; ++i)
    layout.position[i] = {i * sizeof(float), size, NumberType::float32};
  layout.scalars.push_back({"intensity", {3 * sizeof(float), size, NumberType::float32}});
  if (floats == 5)
    layout.scalars.push_back({"ring", {4 * sizeof(float), size, NumberType::float32}});
  return read_records(source, {0, source.size() / size, size}, layout);
}

}  // namespace pointreel
