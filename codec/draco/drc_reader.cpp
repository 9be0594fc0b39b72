#include "codec/draco/drc_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include <draco/point_cloud/point_cloud.h>

#include "codec/draco/draco_decode.h"
#include "codec/draco/drc_header.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

using draco::GeometryAttribute;

template <class T>
double load(const std::uint8_t* bytes) {
  T number;
  std::memcpy(&number, bytes, sizeof(T));
  return static_cast<double>(number);
}

/// Reads a component. Draco's own conversion would read hostile bytes as bool, which is undefined.
double component(const std::uint8_t* bytes, draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return load<std::int8_t>(bytes);
    case draco::DT_UINT8:
      return load<std::uint8_t>(bytes);
    case draco::DT_INT16:
      return load<std::int16_t>(bytes);
    case draco::DT_UINT16:
      return load<std::uint16_t>(bytes);
    case draco::DT_INT32:
      return load<std::int32_t>(bytes);
    case draco::DT_UINT32:
      return load<std::uint32_t>(bytes);
    case draco::DT_INT64:
      return load<std::int64_t>(bytes);
    case draco::DT_UINT64:
      return load<std::uint64_t>(bytes);
    case draco::DT_FLOAT32:
      return load<float>(bytes);
    case draco::DT_FLOAT64:
      return load<double>(bytes);
    case draco::DT_BOOL:
      return *bytes != 0 ? 1.0 : 0.0;
    default:
      return 0.0;
  }
}

/// The value that represents 1 in a type whose values are fractions.
double one_of(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return 127.0;
    case draco::DT_UINT8:
      return 255.0;
    case draco::DT_INT16:
      return 32767.0;
    case draco::DT_UINT16:
      return 65535.0;
    case draco::DT_INT32:
      return 2147483647.0;
    case draco::DT_UINT32:
      return 4294967295.0;
    case draco::DT_INT64:
      return 9223372036854775807.0;
    case draco::DT_UINT64:
      return 18446744073709551615.0;
    default:
      return 1.0;
  }
}

/// The value of point i in an attribute that `is_readable`. Missing components are 0.
glm::dvec3 value(const draco::PointAttribute& attribute, std::uint32_t i) {
  const std::uint8_t* bytes = attribute.GetAddressOfMappedIndex(draco::PointIndex(i));
  const draco::DataType type = attribute.data_type();
  const int components = std::min<int>(3, attribute.num_components());
  glm::dvec3 v(0.0);
  for (int c = 0; c < components; ++c) {
    v[c] = component(bytes + c * draco::DataTypeLength(type), type);
  }
  return v;
}

std::uint16_t to_16_bits(double intensity) {
  // The comparison is false for NaN, which thus becomes 0.
  if (!(intensity > 0.0)) return 0;
  return static_cast<std::uint16_t>(std::lround(std::min(intensity, 1.0) * 65535.0));
}

void read_positions(const draco::PointAttribute& attribute, std::uint32_t n, PointCloud& cloud) {
  const double unit = attribute.normalized() ? one_of(attribute.data_type()) : 1.0;
  std::vector<glm::dvec3> world(n);
  Box box;
  for (std::uint32_t i = 0; i < n; ++i) {
    world[i] = value(attribute, i) / unit;
    if (std::isfinite(world[i].x) && std::isfinite(world[i].y) && std::isfinite(world[i].z)) {
      box.grow(world[i]);
    }
  }
  if (!box.empty()) {
    const glm::dvec3 extent = box.extent();
    const glm::dvec3 far = glm::max(glm::abs(box.min), glm::abs(box.max));
    const double longest = std::max({extent.x, extent.y, extent.z});
    if (std::max({far.x, far.y, far.z}) > 2.0 * longest) cloud.origin = box.min;
  }
  cloud.positions.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) cloud.positions[i] = glm::vec3(world[i] - cloud.origin);
}

void read_normals(const draco::PointAttribute& attribute, std::uint32_t n, PointCloud& cloud) {
  cloud.normals.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) cloud.normals[i] = glm::vec3(value(attribute, i));
}

void read_colors(const draco::PointAttribute& attribute, std::uint32_t n, PointCloud& cloud) {
  const double one = one_of(attribute.data_type());
  const bool gray = attribute.num_components() < 3;
  cloud.colors.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    glm::dvec3 v = value(attribute, i) / one;
    if (gray) v = glm::dvec3(v.x);
    cloud.colors[i] = {to_16_bits(v.x), to_16_bits(v.y), to_16_bits(v.z)};
  }
}

/// The position, normal and colour of a point as bits, so that even NaN equals itself.
using PointBits = std::array<std::uint32_t, 9>;

PointBits bits_of(const PointCloud& cloud, std::size_t i) {
  PointBits bits{};
  std::memcpy(bits.data(), &cloud.positions[i], 12);
  if (cloud.has_normals()) std::memcpy(bits.data() + 3, &cloud.normals[i], 12);
  if (cloud.has_colors()) {
    for (int c = 0; c < 3; ++c) bits[static_cast<std::size_t>(6 + c)] = cloud.colors[i][c];
  }
  return bits;
}

template <class T>
void keep(std::vector<T>& values, const std::vector<std::uint32_t>& kept) {
  if (values.empty()) return;
  for (std::size_t i = 0; i < kept.size(); ++i) values[i] = values[kept[i]];
  values.resize(kept.size());
}

/// Keeps the first of each group of equal points. The order stays the same.
void drop_duplicates(PointCloud& cloud) {
  std::vector<std::pair<PointBits, std::uint32_t>> points(cloud.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) points[i] = {bits_of(cloud, i), i};
  std::sort(points.begin(), points.end());
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i == 0 || points[i].first != points[i - 1].first) kept.push_back(points[i].second);
  }
  if (kept.size() == cloud.size()) return;
  std::sort(kept.begin(), kept.end());
  keep(cloud.positions, kept);
  keep(cloud.normals, kept);
  keep(cloud.colors, kept);
}

Result<PointCloud> convert(const draco::PointCloud& decoded, bool mesh) {
  PointCloud cloud;
  const std::uint32_t n = decoded.num_points();
  const auto* positions = decoded.GetNamedAttribute(GeometryAttribute::POSITION);
  const auto* normals = decoded.GetNamedAttribute(GeometryAttribute::NORMAL);
  const auto* colors = decoded.GetNamedAttribute(GeometryAttribute::COLOR);
  if (n == 0) return cloud;
  if (positions == nullptr) return fail("the Draco data have no positions");
  if (positions->num_components() != 3) {
    return fail("the Draco positions do not have three components");
  }
  for (const auto* attribute : {positions, normals, colors}) {
    if (attribute != nullptr && !is_readable(*attribute, n)) {
      return fail("the Draco data map points to values that do not exist: the file is damaged");
    }
  }
  read_positions(*positions, n, cloud);
  if (normals != nullptr && normals->num_components() == 3) read_normals(*normals, n, cloud);
  if (colors != nullptr) read_colors(*colors, n, cloud);
  if (mesh) drop_duplicates(cloud);
  return cloud;
}

/// What `convert` does not take.
std::vector<std::string> unread_of(const draco::PointCloud& decoded, const PointCloud& cloud) {
  struct Kind {
    GeometryAttribute::Type type;
    const char* name;
    bool first_taken;
  };
  std::vector<std::string> unread;
  for (const Kind& kind : {Kind{GeometryAttribute::NORMAL, "normals", cloud.has_normals()},
                           Kind{GeometryAttribute::COLOR, "colours", cloud.has_colors()},
                           Kind{GeometryAttribute::TEX_COORD, "texture coordinates", false},
                           Kind{GeometryAttribute::GENERIC, "generic attribute", false}}) {
    const int taken = kind.first_taken || cloud.empty() ? 1 : 0;
    for (int i = taken; i < decoded.NumNamedAttributes(kind.type); ++i)
      unread.emplace_back(kind.name);
  }
  return unread;
}

}  // namespace

Result<PointCloud> read_drc(ByteView bytes, const DecodeLimits& limits,
                            std::vector<std::string>* unread) {
  return or_out_of_memory([&]() -> Result<PointCloud> {
    const DrcHeader header = TRY(parse_drc_header(bytes, kPointsPerFileByte, limits));
    const auto decoded = TRY(run_draco_decoder(bytes, header, limits));
    PointCloud cloud = TRY(convert(*decoded, header.mesh));
    if (unread != nullptr) *unread = unread_of(*decoded, cloud);
    return cloud;
  });
}

}  // namespace pointreel
