#include "codec/draco/draco_payload.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <exception>
#include <new>
#include <tuple>
#include <vector>

#include <draco/compression/expert_encode.h>
#include <draco/point_cloud/point_cloud.h>
#include <fmt/format.h>

#include "codec/draco/draco_decode.h"
#include "codec/draco/drc_header.h"
#include "codec/frame_header.h"
#include "common/octree/svo.h"

namespace pointreel {
namespace {

using draco::GeometryAttribute;

constexpr std::size_t kMaxPoints = std::size_t{1} << 26;

Result<void> check(const PointCloud& cloud, const Cube& cube, const DracoOptions& options) {
  const auto in_range = [](int value, int low, int high) { return value >= low && value <= high; };
  if (!in_range(options.position_bits, 1, kMaxDepth)) {
    return fail(fmt::format("--qp {} is not between 1 and {}", options.position_bits, kMaxDepth));
  }
  if (!in_range(options.normal_bits, 2, 16)) {
    return fail(fmt::format("--qn {} is not between 2 and 16", options.normal_bits));
  }
  if (!in_range(options.compression_level, 0, 10)) {
    return fail(fmt::format("--cl {} is not between 0 and 10", options.compression_level));
  }
  if (!is_codable(cube)) {
    return fail(
        fmt::format("a cube with edge {} cannot be coded by Draco; scale the points", cube.edge));
  }
  if (cloud.size() > kMaxPoints) {
    return fail(fmt::format("{} points are more than Draco frames hold ({}); thin them out",
                            cloud.size(), kMaxPoints));
  }
  return {};
}

/// Normals on a grid of 2^bits values with 0 and +-1 among them: -1 + i / steps.
struct NormalGrid {
  explicit NormalGrid(int normal_bits) : bits(normal_bits), steps((1 << (normal_bits - 1)) - 1) {}
  int bits, steps;

  glm::ivec3 quantise(const glm::vec3& n) const {
    const auto one = [this](float v) {
      return static_cast<int>(std::lround(std::clamp(v, -1.0f, 1.0f) * static_cast<float>(steps)));
    };
    return {one(n.x), one(n.y), one(n.z)};
  }
  glm::vec3 value(const glm::ivec3& q) const {
    return glm::vec3(glm::dvec3(q) / static_cast<double>(steps));
  }
  /// Draco divides its range into 2^bits - 1 steps.
  float range() const {
    return static_cast<float>(static_cast<double>((1 << bits) - 1) / static_cast<double>(steps));
  }
};

/// A point as it will be coded: cell, then what tells points in the same cell apart.
struct CodedPoint {
  std::uint64_t key;
  glm::ivec3 normal;
  glm::u16vec3 color;

  auto order() const {
    return std::tuple(key, color.x, color.y, color.z, normal.x, normal.y, normal.z);
  }
};

/// The points in an order that only the set of them decides.
std::vector<CodedPoint> quantise_and_sort(const PointCloud& cloud, const Cube& cube,
                                          const DracoOptions& options, bool normals, bool colors) {
  const SortedPoints sorted = sort_points(cloud, cube, options.position_bits);
  const NormalGrid grid(options.normal_bits);
  std::vector<CodedPoint> points(sorted.points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto [key, index] = sorted.points[i];
    points[i].key = key;
    points[i].normal = normals ? grid.quantise(cloud.normals[index]) : glm::ivec3(0);
    points[i].color = colors ? cloud.colors[index] : glm::u16vec3(0);
  }
  const auto less = [](const CodedPoint& a, const CodedPoint& b) { return a.order() < b.order(); };
  for (auto first = points.begin(); first != points.end();) {
    const auto last = std::find_if(first, points.end(),
                                   [first](const CodedPoint& p) { return p.key != first->key; });
    std::sort(first, last, less);
    first = last;
  }
  return points;
}

/// Adds an attribute of three components; `component(i, c)` is component c of point i.
template <class T, class Component>
int add_attribute(draco::PointCloud& cloud, GeometryAttribute::Type type, draco::DataType data_type,
                  bool normalized, Component component) {
  GeometryAttribute description;
  description.Init(type, nullptr, 3, data_type, normalized, 3 * sizeof(T), 0);
  const int id = cloud.AddAttribute(description, true, cloud.num_points());
  std::uint8_t* out = cloud.attribute(id)->buffer()->data();
  for (std::size_t i = 0; i < cloud.num_points(); ++i) {
    const std::array<T, 3> v = {component(i, 0), component(i, 1), component(i, 2)};
    std::memcpy(out + i * sizeof(v), v.data(), sizeof(v));
  }
  return id;
}

Result<Bytes> encode(const std::vector<CodedPoint>& points, const Cube& cube,
                     const DracoOptions& options, bool normals, bool colors, bool wide_colors) {
  draco::PointCloud cloud;
  cloud.set_num_points(static_cast<std::uint32_t>(points.size()));

  std::vector<glm::vec3> values(points.size());
  const auto value = [&values](std::size_t i, int c) { return values[i][c]; };

  const double cell = std::ldexp(cube.edge, -options.position_bits);
  for (std::size_t i = 0; i < points.size(); ++i) {
    values[i] = glm::vec3((glm::dvec3(morton_decode(points[i].key)) + 0.5) * cell);
  }
  const int position_id =
      add_attribute<float>(cloud, GeometryAttribute::POSITION, draco::DT_FLOAT32, false, value);
  const NormalGrid grid(options.normal_bits);
  int normal_id = -1;
  if (normals) {
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = grid.value(points[i].normal);
    normal_id =
        add_attribute<float>(cloud, GeometryAttribute::NORMAL, draco::DT_FLOAT32, false, value);
  }
  if (colors && wide_colors) {
    add_attribute<std::uint16_t>(cloud, GeometryAttribute::COLOR, draco::DT_UINT16, true,
                                 [&](std::size_t i, int c) { return points[i].color[c]; });
  } else if (colors) {
    add_attribute<std::uint8_t>(
        cloud, GeometryAttribute::COLOR, draco::DT_UINT8, true,
        [&](std::size_t i, int c) { return static_cast<std::uint8_t>(points[i].color[c] / 257); });
  }

  draco::ExpertEncoder encoder(cloud);
  const int speed = 10 - options.compression_level;
  encoder.SetSpeedOptions(speed, speed);
  encoder.SetEncodingMethod(draco::POINT_CLOUD_KD_TREE_ENCODING);
  // Draco's grid has its first and last value at the ends of the range, the cube's cells have their
  // centres half a cell within it.
  const std::array<float, 3> first_center = [&] {
    const auto half = static_cast<float>(0.5 * cell);
    return std::array<float, 3>{half, half, half};
  }();
  encoder.SetAttributeExplicitQuantization(position_id, options.position_bits, 3,
                                           first_center.data(),
                                           static_cast<float>(cube.edge - cell));
  if (normals) {
    const std::array<float, 3> lowest = {-1.0f, -1.0f, -1.0f};
    encoder.SetAttributeExplicitQuantization(normal_id, options.normal_bits, 3, lowest.data(),
                                             grid.range());
  }
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeToBuffer(&buffer);
  if (!status.ok()) {
    return fail(fmt::format("Draco cannot encode the frame ({})", status.error_msg_string()));
  }
  Bytes bytes(buffer.size());
  std::memcpy(bytes.data(), buffer.data(), buffer.size());
  if (points.size() > kFreePoints) {
    const std::uint64_t shortest =
        (points.size() - kFreePoints + kPointsPerFrameByte - 1) / kPointsPerFrameByte;
    if (bytes.size() < shortest) bytes.resize(shortest);
  }
  return bytes;
}

/// Whether the header describes what `encode` writes.
bool is_ours(const DrcHeader& header) {
  if (header.mesh || header.method != draco::POINT_CLOUD_KD_TREE_ENCODING || header.metadata ||
      header.version != 2 * 256 + 3 || header.attribute_decoders != 1 ||
      header.attributes.empty()) {
    return false;
  }
  int last_type = -1;  // POSITION < NORMAL < COLOR: each at most once, in this order
  for (const DrcAttribute& attribute : header.attributes) {
    const bool color = attribute.type == GeometryAttribute::COLOR;
    const bool type_fits =
        color ? attribute.data_type == draco::DT_UINT8 || attribute.data_type == draco::DT_UINT16
              : attribute.data_type == draco::DT_FLOAT32;
    if (attribute.type > GeometryAttribute::COLOR || attribute.type <= last_type ||
        attribute.components != 3 || attribute.normalized != color || !type_fits) {
      return false;
    }
    last_type = attribute.type;
  }
  return header.attributes.front().type == GeometryAttribute::POSITION;
}

/// The values of an attribute of three components that `is_ours` and `is_readable` have accepted.
template <class T>
glm::vec<3, T> read(const draco::PointAttribute& attribute, std::uint32_t i) {
  glm::vec<3, T> v;
  std::memcpy(&v.x, attribute.GetAddressOfMappedIndex(draco::PointIndex(i)), 3 * sizeof(T));
  return v;
}

Result<PointCloud> convert(const draco::PointCloud& decoded, const Cube& cube) {
  PointCloud cloud;
  cloud.origin = cube.origin;
  const std::uint32_t n = decoded.num_points();
  const auto* positions = decoded.GetNamedAttribute(GeometryAttribute::POSITION);
  const auto* normals = decoded.GetNamedAttribute(GeometryAttribute::NORMAL);
  const auto* colors = decoded.GetNamedAttribute(GeometryAttribute::COLOR);
  for (const auto* attribute : {positions, normals, colors}) {
    if (attribute != nullptr && !is_readable(*attribute, n)) {
      return fail("the Draco frame maps points to values that do not exist");
    }
  }
  const auto edge = static_cast<float>(cube.edge);
  cloud.positions.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const glm::vec3 p = read<float>(*positions, i);
    const bool inside = p.x >= 0.0f && p.y >= 0.0f && p.z >= 0.0f && p.x <= edge && p.y <= edge &&
                        p.z <= edge;  // false for NaN
    if (!inside) return fail("the Draco frame has points outside its cube");
    cloud.positions[i] = p;
  }
  if (normals != nullptr) {
    cloud.normals.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) {
      const glm::vec3 v = read<float>(*normals, i);
      // Quantised unit vectors are longer than this, and unknown normals are 0 but for rounding.
      const float length = glm::length(v);
      const bool known = length > 0.5f && std::isfinite(length);
      cloud.normals[i] = known ? v / length : glm::vec3(0.0f);
    }
  }
  if (colors != nullptr) {
    cloud.colors.resize(n);
    const bool wide = colors->data_type() == draco::DT_UINT16;
    for (std::uint32_t i = 0; i < n; ++i) {
      cloud.colors[i] = wide ? read<std::uint16_t>(*colors, i)
                             : glm::u16vec3(read<std::uint8_t>(*colors, i)) * std::uint16_t{257};
    }
  }
  return cloud;
}

}  // namespace

Result<Bytes> encode_draco_payload(const PointCloud& cloud, const Cube& cube,
                                   const DracoOptions& options, bool normals, bool colors) {
  const Result<void> checked = check(cloud, cube, options);
  if (!checked) return tl::unexpected(checked.error());
  if (cloud.empty()) return Bytes{};
  normals = normals && cloud.has_normals();
  colors = colors && cloud.has_colors();
  try {
    return encode(quantise_and_sort(cloud, cube, options, normals, colors), cube, options, normals,
                  colors, !colors_fit_8_bits(cloud));
  } catch (const std::bad_alloc&) {
    return fail("not enough memory to encode the frame with Draco");
  } catch (const std::exception& error) {
    return fail(fmt::format("Draco cannot encode the frame ({})", error.what()));
  }
}

Result<PointCloud> decode_draco_payload(ByteView payload, const Cube& cube,
                                        const DecodeLimits& limits) {
  if (!is_codable(cube)) return fail("the Draco frame has an unusable cube");
  if (payload.empty()) {
    PointCloud none;
    none.origin = cube.origin;
    return none;
  }
  const Result<DrcHeader> header = parse_drc_header(payload, kPointsPerFrameByte, limits);
  if (!header) return tl::unexpected(header.error());
  if (!is_ours(*header)) {
    return fail("the Draco frame is not a kd-tree point cloud of positions, normals and colours");
  }
  const auto decoded = run_draco_decoder(payload, *header, limits);
  if (!decoded) return tl::unexpected(decoded.error());
  try {
    return convert(**decoded, cube);
  } catch (const std::bad_alloc&) {
    return fail("not enough memory for the points of the Draco frame");
  }
}

}  // namespace pointreel
