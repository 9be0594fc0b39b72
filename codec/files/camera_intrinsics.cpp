#include "codec/files/camera_intrinsics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "codec/core/json_fields.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr double kLeastFocalLength = 0.1, kMostPixels = 1e6;

/// Open3D's name, that of ROS in two spellings, and OpenCV's.
constexpr std::array<const char*, 4> kMatrixNames{"intrinsic_matrix", "K", "k", "camera_matrix"};
/// RealSense and Open3D, the tools of TUM's data sets, librealsense's option, and nerfstudio.
constexpr std::array<const char*, 4> kScaleNames{"depth_scale", "depth_factor", "depth_units",
                                                 "depth_unit_scale_factor"};

/// The first of the names that is there, or the first of all.
template <std::size_t kCount>
const char* name_of(Fields& fields, const std::array<const char*, kCount>& names) {
  for (const char* const name : names)
    if (fields.has(name)) return name;
  return names.front();
}

/// Nine numbers, also as three rows of three.
std::optional<std::array<double, 9>> matrix_of(const JsonValue& value) {
  std::vector<double> numbers;
  const auto take = [&](const JsonValue& item) {
    const std::optional<double> number = item.number();
    if (number && numbers.size() < 10) numbers.push_back(*number);
    return number.has_value();
  };
  for (JsonItems row(value); row.next();) {
    if (!row.value().is_array()) {
      if (!take(row.value())) return std::nullopt;
      continue;
    }
    for (JsonItems item(row.value()); item.next();)
      if (!take(item.value())) return std::nullopt;
  }
  if (!value.is_array() || numbers.size() != 9) return std::nullopt;
  std::array<double, 9> matrix{};
  std::copy(numbers.begin(), numbers.end(), matrix.begin());
  return matrix;
}

std::optional<std::array<double, 9>> data_of(const JsonValue& object) {
  Fields fields(object);
  return fields.has("data") ? matrix_of(*fields.value("data")) : std::nullopt;
}

void take_matrix(Fields& fields, const char* name, CameraIntrinsics& camera) {
  const JsonValue& value = *fields.value(name);
  // OpenCV writes an object with the numbers of rows and columns beside them.
  const auto found = value.is_object() ? data_of(value) : matrix_of(value);
  if (!found) return fields.refuse(name, "is not a matrix of nine numbers");
  std::array<double, 9> m = *found;
  // By columns the zeros below the diagonal come first, and by rows last.
  if (m[6] == 0.0 && m[7] == 0.0 && (m[2] != 0.0 || m[5] != 0.0)) {
    std::swap(m[2], m[6]);
    std::swap(m[5], m[7]);
    std::swap(m[1], m[3]);
  }
  if (m[1] != 0.0 || m[2] != 0.0 || m[3] != 0.0 || m[5] != 0.0 || m[8] != 1.0)
    return fields.refuse(name, "is not [fx, 0, 0, 0, fy, 0, cx, cy, 1]");
  camera.fx = m[0];
  camera.fy = m[4];
  camera.cx = m[6];
  camera.cy = m[7];
}

bool has_distortion(Fields& fields) {
  for (const char* key : {"k1", "k2", "k3", "p1", "p2"})
    if (fields.has(key) && fields.value(key)->number().value_or(0.0) != 0.0) return true;
  for (const char* key :
       {"coeffs", "dist_coeffs", "distortion", "distortion_coefficients", "D", "d"}) {
    if (!fields.has(key)) continue;
    for (JsonItems item(*fields.value(key)); item.next();)
      if (item.value().number().value_or(0.0) != 0.0) return true;
  }
  return false;
}

}  // namespace

Result<CameraIntrinsics> parse_camera_intrinsics(std::string_view json) {
  const JsonValue root = TRY(parse_json(json));
  if (!root.is_object()) return fail("is not an object of JSON");
  Fields fields(root);
  CameraIntrinsics camera;
  const char* const matrix = name_of(fields, kMatrixNames);
  if (fields.has(matrix)) {
    take_matrix(fields, matrix, camera);
  } else if (fields.has("fx") || fields.has("fl_x")) {
    const bool short_names = fields.has("fx");
    camera.fx = fields.number(short_names ? "fx" : "fl_x");
    camera.fy = fields.number(short_names ? "fy" : "fl_y");
    camera.cx = fields.number(fields.has("ppx") ? "ppx" : "cx");
    camera.cy = fields.number(fields.has("ppy") ? "ppy" : "cy");
  } else {
    TRY(fields.check());
    return fail("has neither intrinsic_matrix nor fx, fy, cx and cy");
  }
  // False for NaN, too.
  const auto check = [&](const char* name, bool good) {
    if (!good) fields.refuse(name, "is not a number of pixels that a camera can have");
  };
  check("fx", camera.fx >= kLeastFocalLength && camera.fx <= kMostPixels);
  check("fy", camera.fy >= kLeastFocalLength && camera.fy <= kMostPixels);
  check("cx", std::abs(camera.cx) <= kMostPixels);
  check("cy", std::abs(camera.cy) <= kMostPixels);
  const char* const width = fields.has("w") ? "w" : "width";
  const char* const height = fields.has("h") ? "h" : "height";
  if (fields.has(width) || fields.has(height)) {
    camera.width = static_cast<std::uint32_t>(fields.integer(width, 1u << 20));
    camera.height = static_cast<std::uint32_t>(fields.integer(height, 1u << 20));
    if (camera.width == 0 || camera.height == 0) fields.refuse(width, "or height is 0");
  }
  const char* const scale_name = name_of(fields, kScaleNames);
  camera.scale_is_given = fields.has(scale_name);
  if (camera.scale_is_given) {
    const double scale = fields.number(scale_name);
    camera.steps_per_meter = scale < 1.0 ? 1.0 / scale : scale;
    if (!(camera.steps_per_meter >= 1.0 && camera.steps_per_meter <= 1e6))
      fields.refuse(scale_name, "is not from 0.000001 to 1000000");
  }
  camera.distorts = has_distortion(fields);
  TRY(fields.check());
  return camera;
}

}  // namespace pointreel
