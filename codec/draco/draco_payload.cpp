#include "codec/draco/draco_payload.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <tuple>
#include <vector>

#include <draco/compression/expert_encode.h>
#include <draco/point_cloud/point_cloud.h>

#include "codec/core/build.h"
#include "codec/core/morton.h"
#include "codec/draco/draco_decode.h"
#include "codec/draco/drc_header.h"
#include "codec/draco/guarded.h"
#include "codec/octree/frame_header.h"
#include "common/base/concat.h"
#include "common/base/try.h"
#include "pointreel/draco.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

using draco::GeometryAttribute;

constexpr std::size_t kMaxPoints = std::size_t{1} << 26;

Result<void> check(const PointCloud& cloud, const Cube& cube, const DracoOptions& options) {
  const auto in_range = [](int value, int low, int high) { return value >= low && value <= high; };
  if (!in_range(options.position_bits, 1, kMaxDepth)) {
    return fail(ErrorCode::argument,
                concat("--qp ", options.position_bits, " is not between 1 and ", kMaxDepth));
  }
  if (!in_range(options.normal_bits, kMinNormalBits, kMaxNormalBits)) {
    return fail(ErrorCode::argument, concat("--qn ", options.normal_bits, " is not between ",
                                            kMinNormalBits, " and ", kMaxNormalBits));
  }
  if (!in_range(options.compression_level, 0, kMaxCompressionLevel)) {
    return fail(ErrorCode::argument, concat("--cl ", options.compression_level,
                                            " is not between 0 and ", kMaxCompressionLevel));
  }
  TRY(check_codable(cube));
  if (cloud.size() > kMaxPoints) {
    return fail(ErrorCode::limit, concat(cloud.size(), " points are more than the ", kMaxPoints,
                                         " that a Draco frame can hold: thin them out"));
  }
  return {};
}

/// Quantises normals to multiples of 1 / steps, so that 0 and +-1 are among the values.
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
  /// The range of values to give Draco, which divides it into 2^bits - 1 steps.
  float range() const {
    return static_cast<float>(static_cast<double>((1 << bits) - 1) / static_cast<double>(steps));
  }
};

/// How to code a frame, as the options and the cloud determine it.
struct Plan {
  bool sequential = false, normals = false, colors = false, wide_colors = false;
};

Plan plan_for(const PointCloud& cloud, const DracoOptions& options, bool normals, bool colors) {
  const bool automatic = options.method == DracoMethod::automatic;
  Plan plan;
  plan.sequential =
      automatic ? options.compression_level == 0 : options.method == DracoMethod::sequential;
  plan.normals = normals && cloud.has_normals();
  plan.colors = colors && cloud.has_colors();
  plan.wide_colors = plan.colors && !colors_fit_8_bits(cloud);
  return plan;
}

/// A point as it will be coded: its cell, and the attributes by which points in a cell are ordered.
struct CodedPoint {
  std::uint64_t key = 0;
  /// Quantised for the kd-tree; the bits of the floats for the sequential coder, which quantises
  /// normals itself.
  glm::ivec3 normal{0};
  glm::u16vec3 color{0};

  auto order() const {
    return std::tuple(key, color.x, color.y, color.z, normal.x, normal.y, normal.z);
  }
};

/// Quantises the points and puts them in an order that depends only on their set.
std::vector<CodedPoint> quantise_and_sort(const PointCloud& cloud, const Cube& cube,
                                          const DracoOptions& options, const Plan& plan) {
  const SortedPoints sorted = sort_points(cloud, cube, options.position_bits);
  const NormalGrid grid(options.normal_bits);
  std::vector<CodedPoint> points(sorted.points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto [key, index] = sorted.points[i];
    points[i].key = key;
    if (plan.normals) {
      const glm::vec3& normal = cloud.normals[index];
      points[i].normal = plan.sequential ? glm::floatBitsToInt(normal) : grid.quantise(normal);
    }
    if (plan.colors) points[i].color = cloud.colors[index];
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

/// Adds an attribute with `n` components, where `component(i, c)` is component c of point i.
template <class T, int n, class Component>
int add_attribute(draco::PointCloud& cloud, GeometryAttribute::Type type, draco::DataType data_type,
                  bool normalized, Component component) {
  GeometryAttribute description;
  description.Init(type, nullptr, n, data_type, normalized, n * sizeof(T), 0);
  const int id = cloud.AddAttribute(description, true, cloud.num_points());
  std::uint8_t* out = cloud.attribute(id)->buffer()->data();
  for (std::size_t i = 0; i < cloud.num_points(); ++i) {
    std::array<T, n> v;
    for (int c = 0; c < n; ++c) v[static_cast<std::size_t>(c)] = component(i, c);
    std::memcpy(out + i * sizeof(v), v.data(), sizeof(v));
  }
  return id;
}

void add_colors(draco::PointCloud& cloud, const std::vector<CodedPoint>& points, bool wide) {
  if (wide) {
    add_attribute<std::uint16_t, 3>(cloud, GeometryAttribute::COLOR, draco::DT_UINT16, true,
                                    [&](std::size_t i, int c) { return points[i].color[c]; });
  } else {
    add_attribute<std::uint8_t, 3>(
        cloud, GeometryAttribute::COLOR, draco::DT_UINT8, true,
        [&](std::size_t i, int c) { return static_cast<std::uint8_t>(points[i].color[c] / 257); });
  }
}

/// Adds an attribute that says which normals are known, unless all are, because the octahedron
/// cannot represent unknown ones.
void add_known(draco::PointCloud& cloud, const std::vector<glm::vec3>& normals) {
  const auto known = [&normals](std::size_t i, int = 0) {
    return static_cast<std::uint8_t>(normals[i] != glm::vec3(0.0f) ? 1 : 0);
  };
  bool all = true;
  for (std::size_t i = 0; i < normals.size(); ++i) all = all && known(i) != 0;
  if (all) return;
  add_attribute<std::uint8_t, 1>(cloud, GeometryAttribute::GENERIC, draco::DT_UINT8, false, known);
}

Result<Bytes> encode(const std::vector<CodedPoint>& points, const DracoOptions& options,
                     const Plan& plan) {
  draco::PointCloud cloud;
  cloud.set_num_points(static_cast<std::uint32_t>(points.size()));

  std::vector<glm::vec3> values(points.size());
  const auto value = [&values](std::size_t i, int c) { return values[i][c]; };

  for (std::size_t i = 0; i < points.size(); ++i) {
    values[i] = glm::vec3(morton_decode(points[i].key)) + 0.5f;
  }
  const int position_id =
      add_attribute<float, 3>(cloud, GeometryAttribute::POSITION, draco::DT_FLOAT32, false, value);
  const NormalGrid grid(options.normal_bits);
  int normal_id = -1;
  if (plan.normals) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const glm::ivec3& normal = points[i].normal;
      values[i] = plan.sequential ? glm::intBitsToFloat(normal) : grid.value(normal);
    }
    normal_id =
        add_attribute<float, 3>(cloud, GeometryAttribute::NORMAL, draco::DT_FLOAT32, false, value);
  }
  if (plan.colors) add_colors(cloud, points, plan.wide_colors);
  if (plan.normals && plan.sequential) add_known(cloud, values);

  draco::ExpertEncoder encoder(cloud);
  const int speed = kMaxCompressionLevel - options.compression_level;
  encoder.SetSpeedOptions(speed, speed);
  encoder.SetEncodingMethod(plan.sequential ? draco::POINT_CLOUD_SEQUENTIAL_ENCODING
                                            : draco::POINT_CLOUD_KD_TREE_ENCODING);
  // Positions are in units of cells, so that Draco's steps are 1 and its arithmetic is exact. So is
  // the range, which the library passes on as text with six decimals: a small cube's own edge would
  // be lost there.
  const std::array<float, 3> first_center = {0.5f, 0.5f, 0.5f};
  encoder.SetAttributeExplicitQuantization(position_id, options.position_bits, 3,
                                           first_center.data(),
                                           static_cast<float>((1 << options.position_bits) - 1));
  if (plan.normals && plan.sequential) {
    encoder.SetAttributeQuantization(normal_id, options.normal_bits);
  } else if (plan.normals) {
    const std::array<float, 3> lowest = {-1.0f, -1.0f, -1.0f};
    encoder.SetAttributeExplicitQuantization(normal_id, options.normal_bits, 3, lowest.data(),
                                             grid.range());
  }
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeToBuffer(&buffer);
  if (!status.ok()) {
    return fail(concat("Draco cannot encode the frame (", status.error_msg_string(), ")"));
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

/// True if the attribute is one of those that `encode` writes.
bool is_ours(const DrcAttribute& attribute) {
  switch (attribute.type) {
    case GeometryAttribute::POSITION:
    case GeometryAttribute::NORMAL:
      return attribute.data_type == draco::DT_FLOAT32 && attribute.components == 3 &&
             !attribute.normalized;
    case GeometryAttribute::COLOR:
      return (attribute.data_type == draco::DT_UINT8 || attribute.data_type == draco::DT_UINT16) &&
             attribute.components == 3 && attribute.normalized;
    case GeometryAttribute::GENERIC:
      return attribute.data_type == draco::DT_UINT8 && attribute.components == 1 &&
             !attribute.normalized;
    default:
      return false;
  }
}

/// True if the header is one that `encode` writes.
bool is_ours(const DrcHeader& header) {
  if (header.mesh || header.metadata || header.version != 2 * 256 + 3 ||
      header.attribute_decoders != 1 || header.attributes.empty()) {
    return false;
  }
  int last_type = -1;  // POSITION < NORMAL < COLOR < GENERIC, in this order and each at most once
  bool normals = false;
  for (const DrcAttribute& attribute : header.attributes) {
    if (!is_ours(attribute) || attribute.type <= last_type) return false;
    normals = normals || attribute.type == GeometryAttribute::NORMAL;
    last_type = attribute.type;
  }
  const bool sequential = header.method == draco::POINT_CLOUD_SEQUENTIAL_ENCODING;
  return header.attributes.front().type == GeometryAttribute::POSITION &&
         (last_type != GeometryAttribute::GENERIC || (sequential && normals));
}

/// The value of point i in an attribute that `is_ours` and `is_readable` have accepted.
template <class T, int n = 3>
glm::vec<n, T> read(const draco::PointAttribute& attribute, std::uint32_t i) {
  glm::vec<n, T> v;
  std::memcpy(&v.x, attribute.GetAddressOfMappedIndex(draco::PointIndex(i)), n * sizeof(T));
  return v;
}

Result<PointCloud> convert(const draco::PointCloud& decoded, const Cube& cube, int position_bits) {
  PointCloud cloud;
  cloud.origin = cube.origin;
  const std::uint32_t n = decoded.num_points();
  const auto* positions = decoded.GetNamedAttribute(GeometryAttribute::POSITION);
  const auto* normals = decoded.GetNamedAttribute(GeometryAttribute::NORMAL);
  const auto* colors = decoded.GetNamedAttribute(GeometryAttribute::COLOR);
  const auto* known = decoded.GetNamedAttribute(GeometryAttribute::GENERIC);
  for (const auto* attribute : {positions, normals, colors, known}) {
    if (attribute != nullptr && !is_readable(*attribute, n)) {
      return fail("the Draco frame maps points to values that do not exist");
    }
  }
  const double cell = std::ldexp(cube.edge, -position_bits);
  const auto end = static_cast<float>(1 << position_bits);
  cloud.positions.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const glm::vec3 p = read<float>(*positions, i);
    const bool inside = p.x >= 0.0f && p.y >= 0.0f && p.z >= 0.0f && p.x <= end && p.y <= end &&
                        p.z <= end;  // false for NaN
    if (!inside) return fail("the Draco frame has points outside its cube");
    cloud.positions[i] = glm::vec3(glm::dvec3(p) * cell);
  }
  if (normals != nullptr) {
    cloud.normals.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) {
      const glm::vec3 v = read<float>(*normals, i);
      // Quantised unit vectors are longer than this, and unknown normals are 0 up to rounding.
      const float length = glm::length(v);
      const bool usable = length > 0.5f && std::isfinite(length) &&
                          (known == nullptr || read<std::uint8_t, 1>(*known, i).x != 0);
      cloud.normals[i] = usable ? v / length : glm::vec3(0.0f);
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
  TRY(check(cloud, cube, options));
  if (cloud.empty()) return Bytes{};
  const Plan plan = plan_for(cloud, options, normals, colors);
  return guarded(
      "not enough memory to encode the frame with Draco", "Draco cannot encode the frame",
      [&] { return encode(quantise_and_sort(cloud, cube, options, plan), options, plan); });
}

Result<PointCloud> decode_draco_payload(ByteView payload, const Cube& cube, int position_bits,
                                        const DecodeLimits& limits) {
  if (!is_codable(cube)) return fail("the Draco frame has an unusable cube");
  if (payload.empty()) {
    PointCloud none;
    none.origin = cube.origin;
    return none;
  }
  const DrcHeader header = TRY(parse_drc_header(payload, kPointsPerFrameByte, limits));
  if (!is_ours(header)) {
    return fail("the Draco frame is not a point cloud of positions, normals and colours");
  }
  const auto decoded = TRY(run_draco_decoder(payload, header, limits));
  return guarded("not enough memory for the points of the Draco frame",
                 "the points of the Draco frame cannot be used",
                 [&] { return convert(*decoded, cube, position_bits); });
}

}  // namespace pointreel
