#include "codec/draco/drc_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <tuple>

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <draco/metadata/geometry_metadata.h>
#include <gtest/gtest.h>

#include "codec/draco/drc_header.h"

namespace pointreel::drc_reader_test {
namespace {

using draco::GeometryAttribute;

/// Adds an attribute with the given rows of values.
template <class T, std::size_t N>
int add(draco::PointCloud& cloud, GeometryAttribute::Type type, draco::DataType data_type,
        bool normalized, const std::vector<std::array<T, N>>& rows) {
  GeometryAttribute description;
  description.Init(type, nullptr, N, data_type, normalized, N * sizeof(T), 0);
  const int id = cloud.AddAttribute(description, true, cloud.num_points());
  for (std::uint32_t i = 0; i < rows.size(); ++i) {
    cloud.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), rows[i].data());
  }
  return id;
}

template <class Geometry>
Bytes encoded(const Geometry& geometry, int method, int position_bits = 0, int speed = 5) {
  draco::ExpertEncoder encoder(geometry);
  encoder.SetEncodingMethod(method);
  encoder.SetSpeedOptions(speed, speed);
  if (position_bits > 0) {
    for (int i = 0; i < geometry.num_attributes(); ++i) {
      // Quantised texture coordinates would be predicted. A hostile count then makes Draco 1.5.5
      // take up to 256 MiB and some seconds before it fails.
      if (geometry.attribute(i)->data_type() == draco::DT_FLOAT32 &&
          geometry.attribute(i)->attribute_type() != GeometryAttribute::TEX_COORD) {
        encoder.SetAttributeQuantization(i, position_bits);
      }
    }
  }
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeToBuffer(&buffer);
  EXPECT_TRUE(status.ok()) << status.error_msg_string();
  return Bytes(buffer.data(), buffer.data() + buffer.size());
}

PointCloud read_ok(const Bytes& bytes, std::vector<std::string>* unread = nullptr) {
  const auto cloud = read_drc(bytes, {}, unread);
  EXPECT_TRUE(cloud) << (cloud ? "" : cloud.error().message);
  return cloud ? *cloud : PointCloud{};
}

using Rows = std::vector<std::array<float, 3>>;
const Rows kCorners = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 4}, {1, 2, 4}};

std::unique_ptr<draco::PointCloud> corners() {
  auto cloud = std::make_unique<draco::PointCloud>();
  cloud->set_num_points(static_cast<std::uint32_t>(kCorners.size()));
  add<float, 3>(*cloud, GeometryAttribute::POSITION, draco::DT_FLOAT32, false, kCorners);
  return cloud;
}

std::set<std::tuple<float, float, float>> set_of(const std::vector<glm::vec3>& positions) {
  std::set<std::tuple<float, float, float>> set;
  for (const glm::vec3& p : positions) set.insert({p.x, p.y, p.z});
  return set;
}

/// A bent sheet of n x n vertices with two triangles per cell. With `seams`, each triangle has its
/// own texture coordinates, so that a vertex becomes up to six points.
std::unique_ptr<draco::Mesh> sheet(int n, bool seams) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2 * (n - 1) * (n - 1));
  const int position = builder.AddAttribute(GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int texture =
      seams ? builder.AddAttribute(GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32) : -1;
  const auto at = [](int x, int y) {
    return std::array<float, 3>{static_cast<float>(x), static_cast<float>(y),
                                static_cast<float>(x * x % 5 + y)};
  };
  std::uint32_t face = 0;
  const auto triangle = [&](const std::array<float, 3>& a, const std::array<float, 3>& b,
                            const std::array<float, 3>& c) {
    const draco::FaceIndex f(face);
    builder.SetAttributeValuesForFace(position, f, a.data(), b.data(), c.data());
    if (seams) {
      const std::array<float, 2> uv = {static_cast<float>(face), 0.5f};
      builder.SetAttributeValuesForFace(texture, f, uv.data(), uv.data(), uv.data());
    }
    ++face;
  };
  for (int y = 0; y + 1 < n; ++y) {
    for (int x = 0; x + 1 < n; ++x) {
      triangle(at(x, y), at(x + 1, y), at(x, y + 1));
      triangle(at(x + 1, y), at(x + 1, y + 1), at(x, y + 1));
    }
  }
  return builder.Finalize();
}

TEST(DrcReader, reads_point_clouds_of_both_methods_quantised_or_not) {
  const auto cloud = corners();
  std::vector<glm::vec3> expected;
  for (const auto& p : kCorners) expected.push_back({p[0], p[1], p[2]});
  const PointCloud raw = read_ok(encoded(*cloud, draco::POINT_CLOUD_SEQUENTIAL_ENCODING));
  EXPECT_EQ(raw.positions, expected);
  EXPECT_EQ(raw.origin, glm::dvec3(0.0));
  EXPECT_FALSE(raw.has_normals());
  EXPECT_FALSE(raw.has_colors());
  for (int method : {draco::POINT_CLOUD_SEQUENTIAL_ENCODING, draco::POINT_CLOUD_KD_TREE_ENCODING}) {
    PointCloud quantised = read_ok(encoded(*cloud, method, 12));
    ASSERT_EQ(quantised.size(), expected.size());
    for (const glm::vec3& p : expected) {
      EXPECT_TRUE(std::any_of(quantised.positions.begin(), quantised.positions.end(),
                              [&p](const glm::vec3& q) { return glm::length(p - q) < 0.002f; }));
    }
  }
}

TEST(DrcReader, reads_the_vertices_of_meshes_of_both_methods) {
  const auto mesh = sheet(9, false);
  for (int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    for (int speed : {0, 5, 9}) {
      const PointCloud raw = read_ok(encoded(*mesh, method, 0, speed));
      EXPECT_EQ(raw.size(), 81u);
      EXPECT_EQ(set_of(raw.positions).size(), 81u);
      EXPECT_TRUE(set_of(raw.positions).count({8.0f, 8.0f, 12.0f}));
      const PointCloud quantised = read_ok(encoded(*mesh, method, 14, speed));
      EXPECT_EQ(quantised.size(), 81u);
      EXPECT_NEAR(bounds(quantised).max.z, bounds(raw).max.z, 0.01);
    }
  }
}

TEST(DrcReader, joins_vertices_that_texture_seams_split) {
  const auto mesh = sheet(9, true);
  ASSERT_GT(mesh->num_points(), 300u) << "the mesh of this test has no seams";
  for (int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    std::vector<std::string> unread;
    EXPECT_EQ(read_ok(encoded(*mesh, method), &unread).size(), 81u);
    EXPECT_EQ(unread, std::vector<std::string>{"texture coordinates"});
    EXPECT_EQ(read_ok(encoded(*mesh, method, 14)).size(), 81u);
  }
}

TEST(DrcReader, does_not_join_vertices_with_different_normals_or_colours) {
  draco::Mesh mesh;
  mesh.set_num_points(4);
  add<float, 3>(mesh, GeometryAttribute::POSITION, draco::DT_FLOAT32, false,
                {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}});
  add<std::uint8_t, 3>(mesh, GeometryAttribute::COLOR, draco::DT_UINT8, true,
                       {{1, 2, 3}, {1, 2, 3}, {4, 5, 6}, {1, 2, 3}});
  mesh.AddFace({draco::PointIndex(0), draco::PointIndex(1), draco::PointIndex(2)});
  mesh.AddFace({draco::PointIndex(0), draco::PointIndex(2), draco::PointIndex(3)});
  const PointCloud cloud = read_ok(encoded(mesh, draco::MESH_SEQUENTIAL_ENCODING));
  const std::vector<glm::u16vec3> expected = {{257, 514, 771}, {257, 514, 771}, {1028, 1285, 1542}};
  EXPECT_EQ(cloud.colors, expected) << "the first of equal points is kept, and the order too";
}

TEST(DrcReader, keeps_the_duplicates_of_point_clouds) {
  draco::PointCloud cloud;
  cloud.set_num_points(3);
  add<float, 3>(cloud, GeometryAttribute::POSITION, draco::DT_FLOAT32, false,
                {{1, 1, 1}, {1, 1, 1}, {2, 2, 2}});
  EXPECT_EQ(read_ok(encoded(cloud, draco::POINT_CLOUD_SEQUENTIAL_ENCODING)).size(), 3u);
  EXPECT_EQ(read_ok(encoded(cloud, draco::POINT_CLOUD_KD_TREE_ENCODING, 10)).size(), 3u);
}

TEST(DrcReader, reads_positions_of_every_data_type) {
  const auto check = [](auto sample, draco::DataType type) {
    using T = decltype(sample);
    draco::PointCloud cloud;
    cloud.set_num_points(2);
    add<T, 3>(cloud, GeometryAttribute::POSITION, type, false,
              {{T(1), T(2), T(3)}, {T(4), T(5), T(6)}});
    const PointCloud read = read_ok(encoded(cloud, draco::POINT_CLOUD_SEQUENTIAL_ENCODING));
    ASSERT_EQ(read.size(), 2u);
    EXPECT_EQ(read.world(0), glm::dvec3(1, 2, 3)) << type;
    EXPECT_EQ(read.world(1), glm::dvec3(4, 5, 6)) << type;
  };
  check(std::int8_t{}, draco::DT_INT8);
  check(std::uint8_t{}, draco::DT_UINT8);
  check(std::int16_t{}, draco::DT_INT16);
  check(std::uint16_t{}, draco::DT_UINT16);
  check(std::int32_t{}, draco::DT_INT32);
  check(std::uint32_t{}, draco::DT_UINT32);
  check(std::int64_t{}, draco::DT_INT64);
  check(std::uint64_t{}, draco::DT_UINT64);
  check(float{}, draco::DT_FLOAT32);
  check(double{}, draco::DT_FLOAT64);
}

TEST(DrcReader, makes_coordinates_far_from_zero_relative_to_their_corner_in_double) {
  draco::PointCloud cloud;
  cloud.set_num_points(2);
  add<double, 3>(cloud, GeometryAttribute::POSITION, draco::DT_FLOAT64, false,
                 {{4000000.125, 1, 2}, {4000000.25, 1.5, 2}});
  const PointCloud read = read_ok(encoded(cloud, draco::POINT_CLOUD_SEQUENTIAL_ENCODING));
  EXPECT_EQ(read.origin, glm::dvec3(4000000.125, 1, 2));
  EXPECT_EQ(read.world(1), glm::dvec3(4000000.25, 1.5, 2));
}

TEST(DrcReader, reads_colours_of_every_kind) {
  const auto colors = [](auto row, draco::DataType type, bool normalized) {
    using Row = decltype(row);
    draco::PointCloud cloud;
    cloud.set_num_points(1);
    add<float, 3>(cloud, GeometryAttribute::POSITION, draco::DT_FLOAT32, false, {{1, 2, 3}});
    add<typename Row::value_type, std::tuple_size_v<Row>>(cloud, GeometryAttribute::COLOR, type,
                                                          normalized, {row});
    const PointCloud read = read_ok(encoded(cloud, draco::POINT_CLOUD_SEQUENTIAL_ENCODING));
    EXPECT_EQ(read.colors.size(), 1u);
    return read.has_colors() ? read.colors[0] : glm::u16vec3(0);
  };
  for (bool normalized : {false, true}) {
    EXPECT_EQ(colors(std::array<std::uint8_t, 3>{255, 1, 0}, draco::DT_UINT8, normalized),
              glm::u16vec3(65535, 257, 0));
    EXPECT_EQ(colors(std::array<std::uint8_t, 4>{0, 128, 7, 9}, draco::DT_UINT8, normalized),
              glm::u16vec3(0, 128 * 257, 7 * 257));
    EXPECT_EQ(colors(std::array<std::uint16_t, 3>{65535, 12345, 1}, draco::DT_UINT16, normalized),
              glm::u16vec3(65535, 12345, 1));
  }
  EXPECT_EQ(colors(std::array<float, 3>{1.0f, 0.0f, 0.5f}, draco::DT_FLOAT32, false),
            glm::u16vec3(65535, 0, 32768));
  EXPECT_EQ(
      colors(std::array<float, 4>{-1.0f, std::nanf(""), 7.0f, 1.0f}, draco::DT_FLOAT32, false),
      glm::u16vec3(0, 0, 65535));
  EXPECT_EQ(colors(std::array<std::uint8_t, 1>{100}, draco::DT_UINT8, true), glm::u16vec3(25700));
  EXPECT_EQ(colors(std::array<std::uint8_t, 2>{100, 3}, draco::DT_UINT8, true),
            glm::u16vec3(25700));
}

TEST(DrcReader, reads_normals_and_names_what_it_does_not_read) {
  auto cloud = corners();
  Rows normals(kCorners.size(), {0, 0.6f, 0.8f});
  add<float, 3>(*cloud, GeometryAttribute::NORMAL, draco::DT_FLOAT32, false, normals);
  add<std::uint8_t, 1>(*cloud, GeometryAttribute::GENERIC, draco::DT_UINT8, false,
                       {{1}, {2}, {3}, {4}, {5}});
  std::vector<std::string> unread;
  const PointCloud raw = read_ok(encoded(*cloud, draco::POINT_CLOUD_SEQUENTIAL_ENCODING), &unread);
  EXPECT_EQ(unread, std::vector<std::string>{"generic attribute"});
  ASSERT_TRUE(raw.has_normals());
  EXPECT_EQ(raw.normals[2], glm::vec3(0, 0.6f, 0.8f));
  EXPECT_FALSE(raw.has_colors());
  const PointCloud quantised = read_ok(encoded(*cloud, draco::POINT_CLOUD_SEQUENTIAL_ENCODING, 10));
  ASSERT_TRUE(quantised.has_normals());
  EXPECT_LT(glm::length(quantised.normals[2] - glm::vec3(0, 0.6f, 0.8f)), 0.01f);
}

TEST(DrcReader, leaves_positions_that_are_not_finite_to_sanitize) {
  draco::PointCloud cloud;
  cloud.set_num_points(3);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  add<float, 3>(cloud, GeometryAttribute::POSITION, draco::DT_FLOAT32, false,
                {{nan, 0, 0}, {1, 2, 3}, {0, -infinity, 0}});
  PointCloud read = read_ok(encoded(cloud, draco::POINT_CLOUD_SEQUENTIAL_ENCODING));
  EXPECT_EQ(sanitize(read).dropped_positions, 2u);
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read.world(0), glm::dvec3(1, 2, 3));
}

TEST(DrcReader, skips_metadata) {
  auto cloud = corners();
  auto metadata = std::make_unique<draco::GeometryMetadata>();
  metadata->AddEntryString("author", "nobody");
  metadata->AddEntryInt("number", 7);
  auto part = std::make_unique<draco::Metadata>();
  part->AddEntryString("deep", "down");
  metadata->AddSubMetadata("part", std::move(part));
  cloud->AddMetadata(std::move(metadata));
  auto of_positions = std::make_unique<draco::AttributeMetadata>();
  of_positions->AddEntryString("name", "place");
  cloud->AddAttributeMetadata(0, std::move(of_positions));
  const Bytes bytes = encoded(*cloud, draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
  const auto header = parse_drc_header(bytes, kPointsPerFileByte, {});
  ASSERT_TRUE(header) << header.error().message;
  EXPECT_TRUE(header->metadata);
  EXPECT_EQ(header->points, kCorners.size());
  EXPECT_EQ(read_ok(bytes).size(), kCorners.size());
}

// Hostile bytes.

TEST(DrcReader, refuses_bytes_of_another_format_in_one_line) {
  for (const std::string& text : {std::string(), std::string("DRAC"), std::string("ply\n"),
                                  std::string("DRACO"), std::string(400, '\xff')}) {
    const auto cloud =
        read_drc(ByteView(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
    ASSERT_FALSE(cloud);
    EXPECT_EQ(cloud.error().message.find('\n'), std::string::npos);
  }
}

TEST(DrcReader, refuses_newer_versions_and_names_their_number) {
  Bytes bytes = encoded(*corners(), draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
  bytes[5] = 9;
  const auto cloud = read_drc(bytes);
  ASSERT_FALSE(cloud);
  EXPECT_NE(cloud.error().message.find("9.3"), std::string::npos) << cloud.error().message;
}

TEST(DrcReader, refuses_impossible_counts_before_it_allocates_memory) {
  const Bytes cloud = encoded(*corners(), draco::POINT_CLOUD_KD_TREE_ENCODING, 10);
  for (std::uint32_t count : {1u << 31, 0xffffffffu, 0x7fffffffu, 1u << 26}) {
    Bytes damaged = cloud;
    std::memcpy(damaged.data() + 11, &count, 4);
    EXPECT_FALSE(read_drc(damaged)) << count;
  }
  for (int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const Bytes mesh = encoded(*sheet(3, false), method, 10);
    const std::size_t first = method == draco::MESH_SEQUENTIAL_ENCODING ? 11 : 12;
    for (std::size_t which = 0; which < 2; ++which) {
      Bytes damaged(mesh.begin(), mesh.begin() + static_cast<std::ptrdiff_t>(first + which));
      damaged.insert(damaged.end(), {0x80, 0x80, 0x80, 0x80, 0x08});  // 2^31
      damaged.insert(damaged.end(), mesh.begin() + static_cast<std::ptrdiff_t>(first + which + 1),
                     mesh.end());
      const auto read = read_drc(damaged);
      ASSERT_FALSE(read) << method << ' ' << which;
    }
  }
}

TEST(DrcReader, refuses_metadata_that_nest_too_deeply_or_claim_too_much) {
  Bytes bytes = encoded(*corners(), draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
  bytes[10] |= 0x80;  // announces metadata that is missing
  EXPECT_FALSE(read_drc(bytes));
  Bytes entries(bytes.begin(), bytes.begin() + 11);
  entries.insert(entries.end(), {0, 0xff, 0xff, 0xff, 0xff, 0x0f});  // 2^32 - 1 entries, none there
  EXPECT_FALSE(read_drc(entries));                                   // at once
  Bytes nested(bytes.begin(), bytes.begin() + 11);
  nested.push_back(0);  // no attribute metadata
  nested.push_back(0);  // no entries
  nested.push_back(1);  // one nested element
  for (int i = 0; i < 100000; ++i) nested.insert(nested.end(), {0, 0, 1});
  const auto cloud = read_drc(nested);
  ASSERT_FALSE(cloud);
  EXPECT_NE(cloud.error().message.find("truncated"), std::string::npos);
}

/// Reads a copy whose buffer ends with its bytes, so that a sanitizer sees reads past the end.
void expect_harmless(const Bytes& bytes) {
  const Bytes exact(bytes);
  const auto cloud = read_drc(exact, DecodeLimits{1u << 12});
  if (cloud) {
    EXPECT_LE(cloud->size(), 1u << 12);
    EXPECT_TRUE(cloud->normals.empty() || cloud->normals.size() == cloud->size());
    EXPECT_TRUE(cloud->colors.empty() || cloud->colors.size() == cloud->size());
  } else {
    EXPECT_FALSE(cloud.error().message.empty());
  }
}

TEST(DrcReader, never_crashes_on_truncated_files_or_flipped_bits) {
  auto cloud = corners();
  add<std::uint8_t, 3>(*cloud, GeometryAttribute::COLOR, draco::DT_UINT8, true,
                       {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {1, 1, 1}, {2, 2, 2}});
  const auto mesh = sheet(4, true);
  const std::vector<Bytes> files = {
      encoded(*cloud, draco::POINT_CLOUD_SEQUENTIAL_ENCODING),
      encoded(*cloud, draco::POINT_CLOUD_SEQUENTIAL_ENCODING, 8),
      encoded(*cloud, draco::POINT_CLOUD_KD_TREE_ENCODING, 8),
      encoded(*mesh, draco::MESH_SEQUENTIAL_ENCODING, 8),
      encoded(*mesh, draco::MESH_EDGEBREAKER_ENCODING, 8, 0),
      encoded(*mesh, draco::MESH_EDGEBREAKER_ENCODING, 8, 7),
  };
  for (const Bytes& file : files) {
    for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
      Bytes damaged = file;
      damaged[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
      expect_harmless(damaged);
    }
    for (std::size_t size = 0; size < file.size(); ++size) {
      expect_harmless(Bytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size)));
    }
  }
}

}  // namespace
}  // namespace pointreel::drc_reader_test
