#include "codec/draco/draco_codec.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <tuple>

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <gtest/gtest.h>

#include "codec/draco/draco_payload.h"
#include "codec/draco/drc_header.h"
#include "codec/draco/part_sizes.h"
#include "codec/octree/octree_codec.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"

namespace pointreel::draco_codec_test {
namespace {

/// The surface of a sphere with unit normals and random colours that are all different.
PointCloud sphere(std::size_t n, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<float> gauss;
  PointCloud cloud;
  cloud.origin = {10.0, -20.0, 30.0};
  for (std::size_t i = 0; i < n; ++i) {
    const glm::vec3 normal = glm::normalize(glm::vec3(gauss(random), gauss(random), gauss(random)));
    cloud.positions.push_back(1.7f * normal);
    cloud.normals.push_back(normal);
    cloud.colors.push_back(glm::u16vec3(i % 256, i / 256 % 256, random() % 256) *
                           std::uint16_t{257});
  }
  return cloud;
}

PointCloud permuted(const PointCloud& cloud, unsigned seed) {
  std::vector<std::size_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(seed));
  PointCloud out;
  out.origin = cloud.origin;
  for (std::size_t i : order) {
    out.positions.push_back(cloud.positions[i]);
    if (cloud.has_normals()) out.normals.push_back(cloud.normals[i]);
    if (cloud.has_colors()) out.colors.push_back(cloud.colors[i]);
  }
  return out;
}

/// Options to test: levels as draco_encoder takes them, and methods at each end of the range.
std::vector<DracoOptions> ways() {
  std::vector<DracoOptions> ways;
  for (const int level : {0, 5, 7, 10}) {
    for (const DracoMethod method :
         {DracoMethod::automatic, DracoMethod::sequential, DracoMethod::kd_tree}) {
      DracoOptions options;
      options.compression_level = level;
      options.method = method;
      ways.push_back(options);
    }
  }
  return ways;
}

bool is_sequential(const DracoOptions& options) {
  return options.method == DracoMethod::sequential ||
         (options.method == DracoMethod::automatic && options.compression_level == 0);
}

/// The largest allowed error of a normal in radians; see draco_payload.h.
double normal_bound(const DracoOptions& options) {
  const double steps = (1 << options.normal_bits) - 2;
  return std::asin(std::min(1.0, (is_sequential(options) ? 4.0 : std::sqrt(3.0)) / steps)) + 1e-3;
}

Cube cube_of(const PointCloud& cloud) { return bounding_cube(bounds(cloud)); }

Result<DecodedFrame> decode(const EncodedFrame& frame, const DecodeLimits& limits = {}) {
  return decode_draco({Chunks<ByteView>{frame.layers.at(0).geometry, {}, {}}}, limits);
}

PointCloud round_trip(const PointCloud& cloud, const Cube& cube, const DracoOptions& options = {},
                      bool normals = true, bool colors = true) {
  const auto encoded = encode_draco(cloud, cube, options, normals, colors);
  EXPECT_TRUE(encoded) << (encoded ? "" : encoded.error().message);
  if (!encoded) return {};
  const auto decoded = decode(*encoded);
  EXPECT_TRUE(decoded) << (decoded ? "" : decoded.error().message);
  if (!decoded) return {};
  EXPECT_EQ(decoded->cube, cube);
  EXPECT_EQ(decoded->source_points, cloud.size());
  EXPECT_FALSE(decoded->svo);
  return decoded->cloud;
}

using Cell = std::tuple<int, int, int>;

/// The cell, computed by division in the obvious way.
Cell cell_of(const glm::dvec3& world, const Cube& cube, int bits) {
  const double cells = std::ldexp(1.0, bits);
  const glm::dvec3 c = glm::clamp(glm::floor((world - cube.origin) / cube.edge * cells),
                                  glm::dvec3(0.0), glm::dvec3(cells - 1));
  return {static_cast<int>(c.x), static_cast<int>(c.y), static_cast<int>(c.z)};
}

std::vector<Cell> sorted_cells(const PointCloud& cloud, const Cube& cube, int bits) {
  std::vector<Cell> cells;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cells.push_back(cell_of(cloud.world(i), cube, bits));
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

using ColorKey = std::tuple<int, int, int>;
ColorKey key(const glm::u16vec3& c) { return {c.x, c.y, c.z}; }

/// The index of the point of each colour. All colours are different.
std::map<ColorKey, std::size_t> by_color(const PointCloud& cloud) {
  std::map<ColorKey, std::size_t> index;
  for (std::size_t i = 0; i < cloud.size(); ++i) index[key(cloud.colors[i])] = i;
  EXPECT_EQ(index.size(), cloud.size());
  return index;
}

TEST(DracoCodec, every_point_is_restored_within_half_a_cell_with_its_colour_and_normal) {
  const PointCloud cloud = sphere(5000);
  const Cube cube = cube_of(cloud);
  for (const DracoOptions& options : ways()) {
    const PointCloud decoded = round_trip(cloud, cube, options);
    ASSERT_EQ(decoded.size(), cloud.size());
    EXPECT_EQ(decoded.origin, cube.origin);
    const double half = 0.5 * cube.edge / 2048 * 1.0001;
    const auto index = by_color(cloud);
    for (std::size_t i = 0; i < decoded.size(); ++i) {
      const auto found = index.find(key(decoded.colors[i]));
      ASSERT_NE(found, index.end()) << "a colour that was not sent";
      const glm::dvec3 error = glm::abs(decoded.world(i) - cloud.world(found->second));
      EXPECT_LE(std::max({error.x, error.y, error.z}), half);
      const double cosine = glm::dot(decoded.normals[i], cloud.normals[found->second]);
      EXPECT_GE(cosine, std::cos(normal_bound(options)));
      EXPECT_NEAR(glm::length(decoded.normals[i]), 1.0, 1e-5);
    }
  }
}

TEST(DracoCodec, decoded_positions_are_the_centres_of_octree_cells) {
  const PointCloud cloud = sphere(3000);
  const Cube cube = cube_of(cloud);
  for (const auto& [bits, method] : {std::pair{1, DracoMethod::kd_tree},
                                     {1, DracoMethod::sequential},
                                     {2, DracoMethod::kd_tree},
                                     {8, DracoMethod::sequential},
                                     {11, DracoMethod::kd_tree},
                                     {11, DracoMethod::sequential}}) {
    DracoOptions options;
    options.position_bits = bits;
    options.method = method;
    const PointCloud decoded = round_trip(cloud, cube, options);
    EXPECT_EQ(sorted_cells(decoded, cube, bits), sorted_cells(cloud, cube, bits));
    const double cell = std::ldexp(cube.edge, -bits);
    for (std::size_t i = 0; i < decoded.size(); ++i) {
      const glm::dvec3 in_cells = (decoded.world(i) - cube.origin) / cell - 0.5;
      EXPECT_NEAR(glm::length(in_cells - glm::round(in_cells)), 0.0, 0.001);
    }
    const auto octree = encode_octree(
        cloud, cube, OctreeOptions{Entropy::none, DepthRule::fixed(bits)}, false, false);
    ASSERT_TRUE(octree);
    auto cells = sorted_cells(decoded, cube, bits);
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    EXPECT_EQ(cells.size(), octree->coded_points);
  }
}

TEST(DracoCodec, cells_are_exact_at_every_depth_and_size_of_the_cube) {
  for (const double scale : {1e-27, 1e-6, 1.0, 1e6, 1e27}) {
    PointCloud cloud = sphere(1000);
    cloud.origin = glm::dvec3(0.0);
    for (glm::vec3& p : cloud.positions) p = glm::vec3(glm::dvec3(p) * scale);
    const Cube cube = cube_of(cloud);
    for (const int bits : {1, 11, 20, 21}) {
      for (const DracoMethod method : {DracoMethod::kd_tree, DracoMethod::sequential}) {
        DracoOptions options;
        options.position_bits = bits;
        options.method = method;
        const PointCloud decoded = round_trip(cloud, cube, options);
        EXPECT_EQ(sorted_cells(decoded, cube, bits), sorted_cells(cloud, cube, bits))
            << bits << " bits, scale " << scale;
      }
    }
  }
}

TEST(DracoCodec, coordinates_far_from_zero_keep_their_precision) {
  PointCloud cloud = sphere(2000);
  cloud.origin = {4.0e6, -7.0e6, 1.0e6};
  const Cube cube = cube_of(cloud);
  EXPECT_EQ(sorted_cells(round_trip(cloud, cube), cube, 11), sorted_cells(cloud, cube, 11));
}

TEST(DracoCodec, points_on_the_maximum_face_and_outside_are_clamped_to_the_last_cells) {
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {1, 1, 1}, {2, 0.5f, -3}};
  const Cube cube{glm::dvec3(0.0), 1.0};
  const PointCloud decoded = round_trip(cloud, cube);
  const std::vector<Cell> expected = {{0, 0, 0}, {2047, 1024, 0}, {2047, 2047, 2047}};
  EXPECT_EQ(sorted_cells(decoded, cube, 11), expected);
}

TEST(DracoCodec, sixteen_bit_colours_are_restored_exactly) {
  PointCloud cloud = sphere(2000);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.colors[i] = glm::u16vec3(i * 31 + 1, 65535 - i, i);
  }
  std::vector<ColorKey> sent;
  for (const auto& c : cloud.colors) sent.push_back(key(c));
  std::sort(sent.begin(), sent.end());
  for (const DracoOptions& options : ways()) {
    const PointCloud decoded = round_trip(cloud, cube_of(cloud), options);
    std::vector<ColorKey> received;
    for (const auto& c : decoded.colors) received.push_back(key(c));
    std::sort(received.begin(), received.end());
    EXPECT_EQ(received, sent);
  }
}

TEST(DracoCodec, unknown_normals_stay_unknown) {
  PointCloud cloud = sphere(1000);
  for (std::size_t i = 0; i < cloud.size(); i += 3) cloud.normals[i] = glm::vec3(0.0f);
  const auto index = by_color(cloud);
  for (const int bits : {2, 3, 8, 16}) {
    for (DracoOptions options : ways()) {
      options.normal_bits = bits;
      const PointCloud decoded = round_trip(cloud, cube_of(cloud), options);
      ASSERT_EQ(decoded.size(), cloud.size());
      for (std::size_t i = 0; i < decoded.size(); ++i) {
        const glm::vec3 sent = cloud.normals[index.at(key(decoded.colors[i]))];
        if (sent == glm::vec3(0.0f)) {
          EXPECT_EQ(decoded.normals[i], glm::vec3(0.0f));
        } else {
          EXPECT_GE(glm::dot(decoded.normals[i], sent), std::cos(normal_bound(options)))
              << bits << " bits";
        }
      }
    }
  }
}

TEST(DracoCodec, the_sequential_coder_marks_known_normals_only_if_some_are_unknown) {
  PointCloud cloud = sphere(1000);
  DracoOptions options;
  options.method = DracoMethod::sequential;
  const Cube cube = cube_of(cloud);
  const Bytes known = *encode_draco_payload(cloud, cube, options, true, true);
  cloud.normals[7] = glm::vec3(0.0f);
  const Bytes unknown = *encode_draco_payload(cloud, cube, options, true, true);
  const auto attributes = [](const Bytes& bytes) {
    return parse_drc_header(bytes, kPointsPerFrameByte, {})->attributes.size();
  };
  EXPECT_EQ(attributes(known), 3u);
  EXPECT_EQ(attributes(unknown), 4u);
}

TEST(DracoCodec, level_zero_is_coded_sequentially_unless_a_method_is_requested) {
  const PointCloud cloud = sphere(100);
  for (const DracoOptions& options : ways()) {
    const Bytes payload = *encode_draco_payload(cloud, cube_of(cloud), options, true, true);
    const int method = parse_drc_header(payload, kPointsPerFrameByte, {})->method;
    EXPECT_EQ(method, is_sequential(options) ? draco::POINT_CLOUD_SEQUENTIAL_ENCODING
                                             : draco::POINT_CLOUD_KD_TREE_ENCODING);
  }
}

TEST(DracoCodec, bytes_do_not_depend_on_the_order_of_the_points) {
  PointCloud cloud = sphere(3000);
  for (std::size_t i = 0; i < 1000; ++i) {  // many points at the same place with other attributes
    cloud.positions[i] = cloud.positions[i % 7];
  }
  const Cube cube = cube_of(cloud);
  for (const DracoOptions& options : ways()) {
    const auto first = encode_draco(cloud, cube, options, true, true);
    ASSERT_TRUE(first);
    for (unsigned seed = 1; seed < 4; ++seed) {
      const auto other = encode_draco(permuted(cloud, seed), cube, options, true, true);
      ASSERT_TRUE(other);
      EXPECT_EQ(other->layers[0].geometry, first->layers[0].geometry);
    }
  }
}

TEST(DracoCodec, bytes_do_not_depend_on_the_origin_of_the_stored_cloud) {
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}, {4, 5, 6}, {7, 8, 8.5f}};
  const Cube cube = cube_of(cloud);
  PointCloud moved = cloud;
  moved.origin = {1, 2, 3};
  for (auto& p : moved.positions) p -= glm::vec3(1, 2, 3);
  EXPECT_EQ(*encode_draco_payload(moved, cube, {}, true, true),
            *encode_draco_payload(cloud, cube, {}, true, true));
}

TEST(DracoCodec, an_empty_cloud_becomes_an_empty_frame) {
  const Cube cube{{1, 2, 3}, 4.0};
  EXPECT_TRUE(encode_draco_payload({}, cube, {}, true, true)->empty());
  const PointCloud decoded = round_trip({}, cube);
  EXPECT_TRUE(decoded.empty());
  EXPECT_EQ(decoded.origin, cube.origin);
}

TEST(DracoCodec, single_points_and_flat_clouds_are_coded) {
  for (int axes = 0; axes < 3; ++axes) {  // the extent is 0 on three, two and one axes
    PointCloud cloud;
    for (int i = 0; i < (axes == 0 ? 1 : 100); ++i) {
      glm::vec3 p(5.0f);
      for (int a = 0; a < axes; ++a) p[a] += static_cast<float>((i * (a + 3)) % 17);
      cloud.positions.push_back(p);
    }
    const Cube cube = cube_of(cloud);
    EXPECT_EQ(sorted_cells(round_trip(cloud, cube), cube, 11), sorted_cells(cloud, cube, 11));
  }
}

TEST(DracoCodec, duplicates_are_kept_in_any_number) {
  PointCloud cloud;
  cloud.positions.assign(100000, glm::vec3(1, 2, 3));
  const Cube cube{glm::dvec3(0.0), 4.0};
  for (const DracoMethod method : {DracoMethod::kd_tree, DracoMethod::sequential}) {
    DracoOptions options;
    options.method = method;
    const auto payload = encode_draco_payload(cloud, cube, options, true, true);
    ASSERT_TRUE(payload);
    EXPECT_LT(payload->size(), 5000u) << "there is more padding than the decoder needs";
    const PointCloud decoded = round_trip(cloud, cube, options);
    ASSERT_EQ(decoded.size(), cloud.size());
    EXPECT_EQ(sorted_cells(decoded, cube, 11), sorted_cells(cloud, cube, 11));
  }
}

TEST(DracoCodec, attributes_that_are_disabled_or_absent_stay_absent) {
  const PointCloud cloud = sphere(100);
  const Cube cube = cube_of(cloud);
  for (bool normals : {false, true}) {
    for (bool colors : {false, true}) {
      const PointCloud decoded = round_trip(cloud, cube, {}, normals, colors);
      EXPECT_EQ(decoded.has_normals(), normals);
      EXPECT_EQ(decoded.has_colors(), colors);
    }
  }
  PointCloud bare;
  bare.positions = cloud.positions;
  const PointCloud decoded = round_trip(bare, cube_of(bare));
  EXPECT_FALSE(decoded.has_normals());
  EXPECT_FALSE(decoded.has_colors());
}

TEST(DracoCodec, options_and_cubes_out_of_range_are_refused) {
  const PointCloud cloud = sphere(10);
  const Cube cube = cube_of(cloud);
  for (int bits : {0, 22}) {
    EXPECT_FALSE(encode_draco(cloud, cube, DracoOptions{bits, 8, 7}, true, true));
  }
  for (int bits : {1, 17}) {
    EXPECT_FALSE(encode_draco(cloud, cube, DracoOptions{11, bits, 7}, true, true));
  }
  for (int level : {-1, 11}) {
    EXPECT_FALSE(encode_draco(cloud, cube, DracoOptions{11, 8, level}, true, true));
  }
  for (double edge : {0.0, -1.0, 1e300, std::nan(""), HUGE_VAL}) {
    EXPECT_FALSE(encode_draco(cloud, Cube{{}, edge}, {}, true, true)) << edge;
  }
}

TEST(DracoCodec, sizes_of_the_chunks_add_up_to_the_frame) {
  const PointCloud cloud = sphere(2000);
  const Cube cube = cube_of(cloud);
  for (bool normals : {false, true}) {
    for (bool colors : {false, true}) {
      const auto frame = encode_draco(cloud, cube, {}, normals, colors);
      ASSERT_TRUE(frame);
      const auto parts =
          measure_part_sizes(*frame, cloud, cube, {DracoOptions{}, normals, colors, {}});
      ASSERT_TRUE(parts);
      EXPECT_EQ(parts->geometry + parts->colors + parts->normals, frame->size());
      EXPECT_GT(parts->geometry, 0u);
      EXPECT_EQ(parts->colors > 0, colors);
      EXPECT_EQ(parts->normals > 0, normals);
    }
  }
}

// Hostile bytes.

TEST(DracoCodec, truncated_frames_and_flipped_bits_are_errors) {
  const PointCloud cloud = sphere(40);
  for (const int level : {0, 7}) {
    DracoOptions options;
    options.compression_level = level;
    const auto frame = encode_draco(cloud, cube_of(cloud), options, true, true);
    ASSERT_TRUE(frame);
    EncodedFrame damaged = *frame;
    Bytes& bytes = damaged.layers[0].geometry;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
      EXPECT_FALSE(decode(damaged)) << "bit " << bit;
      bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    }
    while (!bytes.empty()) {
      bytes.pop_back();
      EXPECT_FALSE(decode(damaged)) << bytes.size() << " bytes";
    }
  }
}

/// Decodes a copy whose buffer ends with its bytes, so that a sanitizer sees reads past the end.
void expect_harmless(const Bytes& bytes, const Cube& cube, std::size_t most_points) {
  const Bytes exact(bytes);
  const auto decoded = decode_draco_payload(exact, cube, 11, DecodeLimits{1u << 16});
  if (!decoded) {
    EXPECT_FALSE(decoded.error().message.empty());
    return;
  }
  EXPECT_LE(decoded->size(), most_points);
  for (std::size_t i = 0; i < decoded->size(); ++i) {
    const glm::dvec3 p = decoded->world(i) - cube.origin;
    EXPECT_TRUE(p.x >= 0 && p.y >= 0 && p.z >= 0) << "a position is outside the cube";
    EXPECT_LE(std::max({p.x, p.y, p.z}), cube.edge * 1.0001);
    if (decoded->has_normals()) {
      EXPECT_LE(glm::length(decoded->normals[i]), 1.001f);
    }
  }
}

TEST(DracoCodec, truncated_payloads_and_flipped_bits_never_crash) {
  PointCloud cloud = sphere(20);
  cloud.normals[3] = glm::vec3(0.0f);
  const Cube cube = cube_of(cloud);
  for (const auto& [level, method] : {std::pair{0, DracoMethod::sequential},
                                      {7, DracoMethod::sequential},
                                      {0, DracoMethod::kd_tree},
                                      {7, DracoMethod::kd_tree}}) {
    DracoOptions options;
    options.compression_level = level;
    options.method = method;
    const Bytes payload = *encode_draco_payload(cloud, cube, options, true, true);
    for (std::size_t bit = 0; bit < 8 * payload.size(); ++bit) {
      Bytes damaged = payload;
      damaged[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
      expect_harmless(damaged, cube, 1u << 16);
    }
    for (std::size_t size = 1; size < payload.size(); ++size) {
      expect_harmless(Bytes(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(size)),
                      cube, cloud.size());
    }
  }
}

TEST(DracoCodec, impossible_counts_are_refused_before_memory_is_allocated) {
  const PointCloud cloud = sphere(40);
  const Cube cube = cube_of(cloud);
  const Bytes payload = *encode_draco_payload(cloud, cube, {}, true, true);
  for (std::uint32_t count : {1u << 31, 0xffffffffu, 0x7fffffffu, 1u << 27, 100000u}) {
    Bytes damaged = payload;
    std::memcpy(damaged.data() + 11, &count, 4);
    const auto decoded = decode_draco_payload(damaged, cube, 11);
    ASSERT_FALSE(decoded);
    EXPECT_NE(decoded.error().message.find(std::to_string(count)), std::string::npos)
        << decoded.error().message;
  }
}

TEST(DracoCodec, frames_with_more_points_than_the_limit_are_refused) {
  const PointCloud cloud = sphere(40);
  const auto frame = encode_draco(cloud, cube_of(cloud), {}, true, true);
  ASSERT_TRUE(frame);
  EXPECT_TRUE(decode(*frame, DecodeLimits{40}));
  EXPECT_FALSE(decode(*frame, DecodeLimits{39}));
}

TEST(DracoCodec, a_mesh_is_refused_as_a_frame) {
  draco::Mesh mesh;
  mesh.set_num_points(3);
  draco::GeometryAttribute description;
  description.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
  const int id = mesh.AddAttribute(description, true, 3);
  for (std::uint32_t i = 0; i < 3; ++i) {
    const std::array<float, 3> p = {static_cast<float>(i), static_cast<float>(i * i), 0.0f};
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), p.data());
  }
  mesh.AddFace({draco::PointIndex(0), draco::PointIndex(1), draco::PointIndex(2)});
  draco::Encoder encoder;
  draco::EncoderBuffer buffer;
  ASSERT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
  const Bytes bytes(buffer.data(), buffer.data() + buffer.size());
  const auto decoded = decode_draco_payload(bytes, Cube{}, 11);
  ASSERT_FALSE(decoded);
  EXPECT_NE(decoded.error().message.find("not a point cloud"), std::string::npos);
}

}  // namespace
}  // namespace pointreel::draco_codec_test
