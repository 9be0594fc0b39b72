#include "codec/files/ply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace pointreel::ply_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

ByteView view(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

PointCloud read(std::string_view text) {
  Result<PointCloud> cloud = read_ply(view(text));
  EXPECT_TRUE(cloud.has_value()) << (cloud ? "" : cloud.error().message);
  return cloud ? *cloud : PointCloud{};
}

std::string error_of(std::string_view text) {
  const Result<PointCloud> cloud = read_ply(view(text));
  return cloud ? "no error" : cloud.error().message;
}

std::vector<std::string> warnings_of(std::string_view text) {
  ReadNotes notes;
  EXPECT_TRUE(read_ply(view(text), &notes));
  return notes.warnings;
}

/// Encodes `value` as the bytes of a T in either byte order.
template <class T>
std::string bytes_of(double value, bool big_endian) {
  const T typed = static_cast<T>(value);
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &typed, sizeof(T));
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

struct ScalarType {
  const char* name;
  const char* sized_name;
  std::string (*bytes)(double, bool);
};

constexpr std::array<ScalarType, 8> kScalarTypes{{
    {"char", "int8", bytes_of<std::int8_t>},
    {"uchar", "uint8", bytes_of<std::uint8_t>},
    {"short", "int16", bytes_of<std::int16_t>},
    {"ushort", "uint16", bytes_of<std::uint16_t>},
    {"int", "int32", bytes_of<std::int32_t>},
    {"uint", "uint32", bytes_of<std::uint32_t>},
    {"float", "float32", bytes_of<float>},
    {"double", "float64", bytes_of<double>},
}};

constexpr std::string_view kAsciiXyz =
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
    "property float z\nend_header\n";

std::string ascii_xyz(std::string_view body) { return std::string(kAsciiXyz).append(body); }

TEST(Ply, reads_ascii) {
  const PointCloud cloud = read(ascii_xyz("1 2.5 -3e-1\n+4 0 .5"));
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.positions[0], glm::vec3(1, 2.5f, -0.3f));
  EXPECT_EQ(cloud.positions[1], glm::vec3(4, 0, 0.5f));
  EXPECT_EQ(cloud.origin, glm::dvec3(0));
  EXPECT_FALSE(cloud.has_normals() || cloud.has_colors() || cloud.has_radii());
}

TEST(Ply, reads_text_that_begins_with_a_utf8_mark) {
  EXPECT_EQ(read("\xef\xbb\xbf" + ascii_xyz("1 2 3\n4 5 6")).size(), 2u);
}

TEST(Ply, reads_every_scalar_type_by_both_names_in_both_byte_orders) {
  for (const bool big_endian : {false, true}) {
    for (const ScalarType& type : kScalarTypes) {
      for (const char* name : {type.name, type.sized_name}) {
        std::string text = "ply\nformat binary_";
        text += big_endian ? "big_endian" : "little_endian";
        text += " 1.0\nelement vertex 2\n";
        for (const char* axis : {"x", "y", "z"}) {
          text += std::string("property ") + name + " " + axis + "\n";
        }
        text += "end_header\n";
        for (const double v : {1.0, 2.0, 103.0, 4.0, 50.0, 6.0}) text += type.bytes(v, big_endian);
        const PointCloud cloud = read(text);
        ASSERT_EQ(cloud.size(), 2u) << name;
        EXPECT_EQ(cloud.positions[0], glm::vec3(1, 2, 103)) << name << big_endian;
        EXPECT_EQ(cloud.positions[1], glm::vec3(4, 50, 6)) << name << big_endian;
      }
    }
  }
}

TEST(Ply, reads_negative_and_large_integers_exactly) {
  std::string text =
      "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty char x\n"
      "property short y\nproperty uint z\nend_header\n";
  text += bytes_of<std::int8_t>(-7, true) + bytes_of<std::int16_t>(-300, true) +
          bytes_of<std::uint32_t>(4294967295.0, true);
  EXPECT_EQ(read(text).world(0), glm::dvec3(-7, -300, 4294967295.0));
}

TEST(Ply, reads_colours_of_every_type_as_16_bits) {
  // Each type, with its values for full red, medium green and no blue.
  struct Case {
    const char* type;
    std::string (*bytes)(double, bool);
    double full, middle;
    std::uint16_t expected_middle;
  };
  const Case cases[] = {
      {"uchar", bytes_of<std::uint8_t>, 255, 100, 25700},
      {"char", bytes_of<std::int8_t>, -1, 100, 25700},
      {"ushort", bytes_of<std::uint16_t>, 65535, 12345, 12345},
      {"int", bytes_of<std::int32_t>, 255, 100, 25700},
      {"int", bytes_of<std::int32_t>, 65535, 12345, 12345},
      {"uint", bytes_of<std::uint32_t>, 255, 100, 25700},
      {"short", bytes_of<std::int16_t>, 255, 100, 25700},
      {"float", bytes_of<float>, 1.5, 0.25, 16384},
      {"double", bytes_of<double>, 1.0, 100.0 / 255.0, 25700},
  };
  for (const Case& c : cases) {
    std::string text =
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\n"
        "property float y\nproperty float z\n";
    for (const char* name : {"red", "green", "blue"}) {
      text += std::string("property ") + c.type + " " + name + "\n";
    }
    text += "end_header\n" + std::string(12, '\0');
    for (const double v : {c.full, c.middle, 0.0}) text += c.bytes(v, false);
    const PointCloud cloud = read(text);
    ASSERT_EQ(cloud.colors.size(), 1u) << c.type;
    EXPECT_EQ(cloud.colors[0], glm::u16vec3(65535, c.expected_middle, 0)) << c.type;
  }
}

TEST(Ply, reads_floats_from_0_to_255_as_such) {
  const auto colors = [](const std::string& first, const std::string& second) {
    const std::string text =
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        "property float z\nproperty float r\nproperty float g\nproperty float b\nend_header\n"
        "0 0 0 " +
        first + "\n1 0 0 " + second + "\n";
    return read_ply(view(text)).value().colors;
  };
  EXPECT_THAT(colors("255 0 51", "1 0.5 0"),
              ElementsAre(glm::u16vec3(65535, 0, 13107), glm::u16vec3(257, 129, 0)));
  EXPECT_THAT(colors("1 0 0.2", "1.5 0 0"),
              ElementsAre(glm::u16vec3(65535, 0, 13107), glm::u16vec3(65535, 0, 0)));
  EXPECT_THAT(colors("1 0 0.2", "inf 1e30 0"),
              ElementsAre(glm::u16vec3(65535, 0, 13107), glm::u16vec3(65535, 65535, 0)));
}

TEST(Ply, reads_16_bit_colours_that_are_at_most_255_as_bytes) {
  const auto colors = [](const std::string& first, const std::string& second) {
    return read(
               "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
               "property float z\nproperty ushort red\nproperty ushort green\n"
               "property ushort blue\nend_header\n0 0 0 " +
               first + "\n1 0 0 " + second + "\n")
        .colors;
  };
  EXPECT_THAT(colors("255 0 51", "1 128 0"),
              ElementsAre(glm::u16vec3(65535, 0, 13107), glm::u16vec3(257, 32896, 0)));
  EXPECT_THAT(colors("256 0 51", "65535 42 12345"),
              ElementsAre(glm::u16vec3(256, 0, 51), glm::u16vec3(65535, 42, 12345)));
}

TEST(Ply, reads_a_nan_colour_as_black) {
  const PointCloud cloud = read(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty float r\nproperty float g\nproperty float b\nend_header\n"
      "0 0 0 nan -1 inf\n");
  EXPECT_EQ(cloud.colors.at(0), glm::u16vec3(0, 0, 65535));
}

TEST(Ply, clamps_ascii_colours_of_bytes) {
  const PointCloud cloud = read(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "end_header\n0 0 0 300 -5 nan\n1 0 0 12.7 1e300 -inf\n");
  EXPECT_EQ(cloud.colors.at(0), glm::u16vec3(65535, 0, 0));
  EXPECT_EQ(cloud.colors.at(1), glm::u16vec3(12 * 257, 65535, 0));
}

TEST(Ply, accepts_alternative_names_of_colours_and_normals) {
  const PointCloud cloud = read(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty uchar diffuse_blue\nproperty float x\n"
      "property float normal_z\nproperty float y\nproperty uchar diffuse_red\nproperty float z\n"
      "property float normal_x\nproperty uchar diffuse_green\nproperty float normal_y\n"
      "property float radius\nproperty uchar alpha\nend_header\n"
      "3 0.1 0.3 0.2 1 0.3 0.1 2 0.2 0.5 255\n");
  EXPECT_EQ(glm::vec3(cloud.world(0)), glm::vec3(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(cloud.normals.at(0), glm::vec3(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(cloud.colors.at(0), glm::u16vec3(257, 514, 771));
  EXPECT_EQ(cloud.radii.at(0), 0.5f);
}

TEST(Ply, reads_scalar_properties_without_another_meaning_as_scalar_fields) {
  const PointCloud cloud = read(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty uchar class\nproperty float x\n"
      "property float y\nproperty list uchar int tags\nproperty float z\n"
      "property double intensity\nproperty uchar red\nend_header\n"
      "2 0 0 1 7 0 0.25 9\n6 1 1 0 1 unknown 8\n");
  ASSERT_EQ(cloud.scalars.size(), 3u);
  EXPECT_EQ(cloud.scalars[0].name, "class");
  EXPECT_EQ(cloud.scalars[0].values, (std::vector<float>{2, 6}));
  EXPECT_EQ(cloud.scalars[1].name, "intensity");
  EXPECT_EQ(cloud.scalars[1].values[0], 0.25f);
  EXPECT_TRUE(std::isnan(cloud.scalars[1].values[1]));
  EXPECT_EQ(cloud.scalars[2].name, "red") << "without green and blue, it is no colour";
}

TEST(Ply, reads_no_more_scalar_fields_than_a_cloud_may_have_and_names_the_others) {
  const std::string long_name(kMaxScalarName + 1, 'n');
  std::string header =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float " + long_name + "\n";
  std::string row = "0 ";
  for (std::size_t i = 0; i < kMaxScalars + 1; ++i) {
    header += "property int s" + std::to_string(i) + "\n";
    row += std::to_string(i) + " ";
  }
  header += "property float x\nproperty float y\nproperty float z\nend_header\n";
  const std::string file = header + row + "1 2 3\n";
  ReadNotes notes;
  const PointCloud cloud = read_ply(view(file), &notes).value();
  ASSERT_EQ(cloud.scalars.size(), kMaxScalars);
  EXPECT_EQ(cloud.scalars.back().name, "s7");
  EXPECT_EQ(cloud.scalars.back().values, std::vector<float>{7});
  ASSERT_EQ(notes.unread.size(), 2u);
  EXPECT_EQ(notes.unread[1], "s8");
}

TEST(Ply, writes_scalar_fields_so_that_they_are_read_again) {
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}, {4, 5, 6}};
  cloud.radii = {1, 2};
  cloud.scalars = {{"intensity", {0.1f, std::numeric_limits<float>::max()}},
                   {"radius", {3, 4}},
                   {"scan angle", {-5, 6}},
                   {"scan_angle", {7, 8}}};
  const PointCloud again = read_ply(ply_bytes(cloud)).value();
  EXPECT_EQ(again.radii, cloud.radii);
  ASSERT_EQ(again.scalars.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(again.scalars[i].values, cloud.scalars[i].values);
  EXPECT_EQ(again.scalars[0].name, "intensity");
  EXPECT_EQ(again.scalars[1].name, "scalar_radius");
  EXPECT_EQ(again.scalars[2].name, "scan_angle");
  EXPECT_EQ(again.scalars[3].name, "scalar_scan_angle");
}

TEST(Ply, treats_an_incomplete_attribute_as_absent) {
  const PointCloud cloud = read(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty float nx\nproperty float ny\nproperty uchar red\n"
      "property uchar green\nproperty list uchar uchar blue\nend_header\n1 2 3 4 5 6 7 2 8 9\n");
  EXPECT_EQ(glm::vec3(cloud.world(0)), glm::vec3(1, 2, 3));
  EXPECT_FALSE(cloud.has_normals());
  EXPECT_FALSE(cloud.has_colors());
}

TEST(Ply, skips_lists_and_other_elements_anywhere) {
  const std::string header =
      "element face 2\nproperty list uchar int vertex_indices\nproperty uchar flags\n"
      "element nothing 4000000000000\n"
      "element vertex 2\nproperty float x\nproperty list uint short weights\nproperty float y\n"
      "property float z\nelement edge 1\nproperty int a\nend_header\n";
  const PointCloud ascii =
      read("ply\nformat ascii 1.0\n" + header + "3 0 1 2 9\n0 9\n1 2 7 8 3 4\n5 0 6 7\n1\n");
  ASSERT_EQ(ascii.size(), 2u);
  EXPECT_EQ(ascii.positions[0], glm::vec3(1, 3, 4));
  EXPECT_EQ(ascii.positions[1], glm::vec3(5, 6, 7));

  for (const bool big : {false, true}) {
    std::string text =
        big ? "ply\nformat binary_big_endian 1.0\n" : "ply\nformat binary_little_endian 1.0\n";
    text += header;
    text += "\x03" + std::string(12, '\0') + "\x09";
    text += std::string(1, '\0') + "\x09";
    text += bytes_of<float>(1, big) + bytes_of<std::uint32_t>(2, big) + "ABCD" +
            bytes_of<float>(3, big) + bytes_of<float>(4, big);
    text += bytes_of<float>(5, big) + bytes_of<std::uint32_t>(0, big) + bytes_of<float>(6, big) +
            bytes_of<float>(7, big);
    text += std::string(4, '\0');
    const PointCloud binary = read(text);
    ASSERT_EQ(binary.size(), 2u);
    EXPECT_EQ(binary.positions, ascii.positions);
    // Without its last byte, the same file is cut off within the edges, which nobody uses.
    EXPECT_THAT(warnings_of(std::string_view(text).substr(0, text.size() - 1)),
                ElementsAre(HasSubstr("property a of edge 0 of 1; all vertices are read")));
  }
}

TEST(Ply, refuses_damaged_elements_that_stand_before_the_vertices) {
  EXPECT_THAT(error_of("ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int i\n"
                       "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                       "end_header\n-1\n1 2 3\n"),
              HasSubstr("the list i of face 0 of 1"));
}

TEST(Ply, warns_of_vertices_that_the_header_does_not_count) {
  EXPECT_THAT(warnings_of(ascii_xyz("1 2 3\n4 5 6\n7 8 9\n")),
              ElementsAre(HasSubstr("the header says 2 vertices, but more follow")));
  EXPECT_THAT(warnings_of(ascii_xyz("1 2 3\n4 5 6\nthe end\n")), IsEmpty());
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\n"
      "property uchar y\nproperty uchar z\nend_header\n";
  EXPECT_THAT(warnings_of(header + "abc"), IsEmpty());
  EXPECT_THAT(warnings_of(header + "abcdef"), ElementsAre(HasSubstr("more follow")));
}

TEST(Ply, does_not_regard_the_case_of_letters) {
  const PointCloud cloud = read(
      "PLY\nFORMAT ASCII 1.0\nElement Vertex 1\nProperty Float X\nproperty FLOAT Y\n"
      "property float Z\nproperty uchar Red\nproperty uchar Green\nproperty uchar BLUE\n"
      "property float NX\nproperty float ny\nproperty float Nz\nEND_HEADER\n"
      "1 2 3 4 5 6 0 0 1\n");
  EXPECT_EQ(cloud.world(0), glm::dvec3(1, 2, 3));
  EXPECT_EQ(cloud.colors.at(0), glm::u16vec3(4 * 257, 5 * 257, 6 * 257));
  EXPECT_EQ(cloud.normals.at(0), glm::vec3(0, 0, 1));
  EXPECT_FALSE(cloud.has_scalars());
}

TEST(Ply, prefers_a_name_in_the_usual_case) {
  const PointCloud cloud = read(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float X\nproperty float x\n"
      "property float y\nproperty float z\nend_header\n9 1 2 3\n");
  EXPECT_EQ(cloud.world(0), glm::dvec3(1, 2, 3));
  EXPECT_EQ(cloud.scalars.at(0).name, "X");
}

TEST(Ply, skips_unknown_lines_of_the_header_with_a_warning) {
  const auto with = [](const std::string& line) {
    return "ply\nformat ascii 1.0\n" + line +
           "\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
           "end_header\n1 2 3\n";
  };
  for (const char* comment : {"comment: exported", "# hello", "COMMENT x", "obj_info: 3"})
    EXPECT_THAT(warnings_of(with(comment)), IsEmpty());
  EXPECT_THAT(warnings_of(with("elephant\x1b[31m 1")),
              ElementsAre("line 3: is skipped: unknown keyword 'elephant?[31m'"));
  std::string many = "a";
  for (int i = 0; i < 1000; ++i) many += "\nb";
  EXPECT_LT(warnings_of(with(many)).size(), 10u);
}

TEST(Ply, reads_lines_that_end_in_cr_alone) {
  const std::string ascii =
      "ply\rformat ascii 1.0\relement vertex 2\rproperty float x\rproperty float y\r"
      "property float z\rend_header\r1 2 3\r4 five 6\r";
  EXPECT_THAT(error_of(ascii), StartsWith("line 9: property y"));
  std::string binary =
      "ply\rformat binary_little_endian 1.0\relement vertex 1\rproperty uchar x\r"
      "property uchar y\rproperty uchar z\rend_header\r";
  binary += "\n\r\x03";  // not the rest of a line end
  EXPECT_EQ(read(binary).world(0), glm::dvec3(10, 13, 3));
}

/// A vertex at 0 0 0 with properties of type float.
std::string floats(const std::vector<std::pair<std::string, float>>& properties) {
  std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\n"
      "property float y\nproperty float z\n";
  std::string row(12, '\0');
  for (const auto& [name, value] : properties) {
    header += "property float " + name + "\n";
    row += bytes_of<float>(static_cast<double>(value), false);
  }
  return header + "end_header\n" + row;
}

TEST(Ply, reads_the_mean_colours_of_splats_and_leaves_their_shape_out) {
  const std::string text = floats({{"f_dc_0", 0.0f},
                                   {"f_dc_1", 1.0f},
                                   {"f_dc_2", -3.0f},
                                   {"f_rest_0", 1.0f},
                                   {"f_rest_1", 1.0f},
                                   {"opacity", 1.0f},
                                   {"scale_0", 1.0f},
                                   {"scale_1", 1.0f},
                                   {"rot_0", 1.0f},
                                   {"label", 7.0f}});
  ReadNotes notes;
  const PointCloud cloud = read_ply(view(text), &notes).value();
  ASSERT_EQ(cloud.colors.size(), 1u);
  EXPECT_NEAR(cloud.colors[0].x, 0.5 * 65535, 1);
  EXPECT_NEAR(cloud.colors[0].y, 0.7820948 * 65535, 1);
  EXPECT_EQ(cloud.colors[0].z, 0);
  ASSERT_EQ(cloud.scalars.size(), 1u);
  EXPECT_EQ(cloud.scalars[0].name, "label");
  EXPECT_THAT(notes.unread, ElementsAre("f_rest_*", "opacity", "scale_*", "rot_*"));
}

TEST(Ply, knows_scales_and_rotations_as_scalar_fields_where_nothing_is_a_splat) {
  EXPECT_EQ(read(floats({{"scale_0", 2.0f}, {"opacity", 1.0f}})).scalars.size(), 2u);
}

TEST(Ply, reads_colours_under_other_names) {
  EXPECT_EQ(read(floats({{"Rf", 1.0f}, {"Gf", 0.2f}, {"Bf", 0.0f}})).colors.at(0),
            glm::u16vec3(65535, 13107, 0));
  const glm::u16vec3 expected(0x10 * 257, 0x20 * 257, 0x30 * 257);
  // As a number, and as the bits of a float, which is NaN here.
  const std::string head =
      "element vertex 1\nproperty uchar x\nproperty uchar y\nproperty uchar z\n";
  const std::string binary = "ply\nformat binary_little_endian 1.0\n" + head;
  for (const char* type : {"uint", "int", "float"}) {
    for (const char* name : {"rgb", "rgba", "RGBA"}) {
      const std::string text = binary + "property " + type + " " + name + "\nend_header\n123";
      EXPECT_EQ(read(text + "\x30\x20\x10\xff").colors.at(0), expected) << type;
      EXPECT_EQ(read(text + "\x01\x02\x90\xff").colors.at(0),
                glm::u16vec3(0x90, 2, 1) * glm::u16vec3(257));
    }
  }
  const std::string ascii = "ply\nformat ascii 1.0\n" + head;
  EXPECT_EQ(read(ascii + "property uint rgba\nend_header\n1 2 3 4279246896\n").colors.at(0),
            expected);
  EXPECT_EQ(read(ascii + "property float rgb\nend_header\n1 2 3 1.480915e-39\n").colors.at(0).x,
            0x10 * 257);
  EXPECT_EQ(read(ascii + "property uchar rgb\nend_header\n1 2 3 4\n").scalars.at(0).name, "rgb");
}

TEST(Ply, writes_scalar_fields_so_that_none_is_taken_for_a_colour) {
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}};
  for (const char* name : {"R", "G", "B", "rgb", "f_dc_0", "f_dc_1", "f_dc_2", "Rf"})
    cloud.scalars.push_back({name, {0.5f}});
  const PointCloud again = read_ply(ply_bytes(cloud)).value();
  EXPECT_FALSE(again.has_colors());
  EXPECT_EQ(again.scalars.size(), 8u);
}

TEST(Ply, keeps_the_precision_of_far_points_though_some_are_at_zero) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 40\nproperty double x\nproperty double y\n"
      "property double z\nend_header\n";
  for (int i = 0; i < 40; ++i)
    text += i % 8 == 3 ? "0 0 0\n" : "500000.125 5400000.0625 " + std::to_string(i) + ".03125\n";
  const PointCloud cloud = read(text);
  EXPECT_EQ(cloud.world(0), glm::dvec3(500000.125, 5400000.0625, 0.03125));
  EXPECT_EQ(cloud.world(3), glm::dvec3(0));
}

TEST(Ply, tolerates_crlf_comments_tabs_and_trailing_garbage) {
  const std::string header =
      "comment made by hand\r\nobj_info 12 % end_header\r\nelement\tvertex  1\r\ncomment\r\n"
      "property float x\r\n\r\nproperty  float y \r\nproperty float z\r\nend_header\r\n";
  const PointCloud ascii =
      read("ply\r\nformat ascii 1.0\r\n" + header + "1\t2 3\r\n\r\nand whatever follows \x80\xff");
  ASSERT_EQ(ascii.size(), 1u);
  EXPECT_EQ(ascii.world(0), glm::dvec3(1, 2, 3));
  const PointCloud binary =
      read("ply\r\nformat binary_little_endian 1.0\r\n" + header + bytes_of<float>(1, false) +
           bytes_of<float>(2, false) + bytes_of<float>(3, false) + "trailing");
  ASSERT_EQ(binary.size(), 1u);
  EXPECT_EQ(binary.world(0), glm::dvec3(1, 2, 3));
}

TEST(Ply, reads_an_empty_cloud) {
  EXPECT_TRUE(read("ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n"
                   "property float z\nend_header\n")
                  .empty());
  EXPECT_TRUE(read(std::string_view(reinterpret_cast<const char*>(ply_bytes({}).data()),
                                    ply_bytes({}).size()))
                  .empty());
}

TEST(Ply, names_the_place_and_property_if_the_header_promises_too_much) {
  std::string binary =
      "ply\nformat binary_little_endian 1.0\nelement vertex 2000000000\nproperty float x\n"
      "property float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nend_header\n";
  const std::size_t header_size = binary.size();
  binary += std::string(15 + 5, '\0');  // one vertex, and the second up to the middle of y
  EXPECT_EQ(error_of(binary), "byte " + std::to_string(header_size + 20) +
                                  ": the data end within property y of vertex 1 of 2000000000");
  EXPECT_EQ(error_of(ascii_xyz("1 2 3\n4 5\n")),
            "line 10: the data end before property z of vertex 1 of 2");
  // With a list in the vertex element, the size of a row is unknown.
  EXPECT_THAT(error_of("ply\nformat binary_big_endian 1.0\nelement vertex 4000000000\n"
                       "property uchar x\nproperty uchar y\nproperty uchar z\n"
                       "property list uint double w\nend_header\nxyz\xff\xff\xff\xff"),
              HasSubstr("property w of vertex 0 of 4000000000"));
}

TEST(Ply, allocates_memory_for_the_data_and_not_for_the_header) {
  // 2^64 - 1 vertices of 12 bytes: neither the product nor the sum may wrap around.
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\n"
      "property float x\nproperty float y\nproperty float z\nend_header\n";
  text += std::string(1200, '\0');
  EXPECT_THAT(error_of(text), HasSubstr("property x of vertex 100 of 18446744073709551615"));
  EXPECT_THAT(error_of("ply\nformat ascii 1.0\nelement vertex 18446744073709551615\n"
                       "property float x\nproperty float y\nproperty float z\nend_header\n1 2 3"),
              HasSubstr("property x of vertex 1 of 18446744073709551615"));
}

TEST(Ply, names_the_line_of_errors_in_the_header) {
  const auto header = [](std::string_view lines) {
    return "ply\nformat ascii 1.0\n" + std::string(lines) + "end_header\n";
  };
  EXPECT_EQ(error_of(""), "line 1: not a PLY file");
  EXPECT_EQ(error_of("plywood\nformat ascii 1.0\n"), "line 1: not a PLY file");
  EXPECT_EQ(error_of("solid cube\n"), "line 1: not a PLY file");
  EXPECT_EQ(error_of("ply\nformat ascii 1.0\nelement vertex 3\n"),
            "line 4: the file ends before the header's end_header");
  EXPECT_EQ(error_of("ply\nelement vertex 0\nend_header\n"),
            "line 3: the header ends without a format");
  EXPECT_THAT(error_of("ply\nformat binary 1.0\nend_header\n"),
              StartsWith("line 2: unknown format"));
  EXPECT_EQ(error_of(header("")), "the header declares no element vertex");
  EXPECT_EQ(error_of(header("property float x\n")),
            "line 3: a property stands before the first element");
  EXPECT_EQ(error_of(header("element vertex -1\n")),
            "line 3: element vertex has the count '-1', which is not a number of rows");
  EXPECT_EQ(error_of(header("element vertex 18446744073709551616\n")),
            "line 3: element vertex has the count '18446744073709551616', which is not a number of "
            "rows");
  EXPECT_EQ(error_of(header("element vertex 1\nelement vertex 1\n")),
            "line 4: element vertex is declared twice");
  EXPECT_EQ(error_of(header("element vertex 1\nproperty half x\n")),
            "line 4: property x has the unknown type 'half'");
  EXPECT_EQ(error_of(header("element vertex 1\nproperty float x\nproperty int x\n")),
            "line 5: property x of element vertex is declared twice");
  EXPECT_EQ(error_of(header("element face 1\nproperty list float int i\n")),
            "line 4: list property i counts its entries in 'float', which is not an integer type");
  EXPECT_EQ(error_of(header("element vertex 1\nproperty float\n")),
            "line 4: a property of element vertex lacks its type or name");
  EXPECT_EQ(error_of(header("element vertex 1\nproperty float x\nproperty float z\n")),
            "line 3: element vertex has no scalar property y");
  EXPECT_EQ(error_of(header("element vertex 1\nproperty list uchar float x\n")),
            "line 3: element vertex has no scalar property x");
}

TEST(Ply, names_the_line_or_byte_of_errors_in_the_data) {
  EXPECT_EQ(error_of(ascii_xyz("1 2 3\n4 five 6\n")),
            "line 9: property y of vertex 1 of 2 is 'five', which is not a number");
  EXPECT_EQ(error_of(ascii_xyz("1 2 3x\n4 5 6\n")),
            "line 8: property z of vertex 0 of 2 is '3x', which is not a number");
  const std::string lists =
      " 1.0\nelement face 1\nproperty list char uchar i\nelement vertex 0\nproperty float x\n"
      "property float y\nproperty float z\nend_header\n";
  EXPECT_EQ(error_of("ply\nformat ascii" + lists + "-1\n"),
            "line 10: the list i of face 0 of 1 has the length '-1'");
  EXPECT_THAT(error_of("ply\nformat binary_little_endian" + lists + "\xff"),
              HasSubstr(": the list i of face 0 of 1 has a negative length"));
}

TEST(Ply, keeps_the_origin_at_zero_for_coordinates_near_it) {
  EXPECT_EQ(read(ascii_xyz("-1 0 0\n1 4 0\n")).origin, glm::dvec3(0));
  // The largest coordinate is 4 and the longest extent is 2: exactly twice does not exceed the
  // limit.
  EXPECT_EQ(read(ascii_xyz("4 0 0\n2 0 0\n")).origin, glm::dvec3(0));
  EXPECT_EQ(read(ascii_xyz("4.5 0 -1\n2.5 0 -1\n")).origin, glm::dvec3(2.5, 0, -1));
}

TEST(Ply, subtracts_a_far_origin_in_double) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
      "property double z\nend_header\n";
  const PointCloud cloud =
      read(header + "4500000.125 -1000000.0625 812.5\n4500001.0001 -1000000 812.5001\n");
  EXPECT_EQ(cloud.origin, glm::dvec3(4500000.125, -1000000.0625, 812.5));
  EXPECT_NEAR(cloud.world(1).x, 4500001.0001, 1e-7);
  EXPECT_NEAR(cloud.world(1).z, 812.5001, 1e-7);
}

TEST(Ply, points_at_zero_cost_the_others_no_digits_however_many_they_are) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 300\nproperty double x\nproperty double y\n"
      "property double z\nend_header\n";
  for (int i = 0; i < 300; ++i)
    text += i % 3 < 2 ? "0 0 0\n" : fmt::format("{} 5423456.789 123.456\n", 512345.678 + i);
  const PointCloud cloud = read(text);
  ASSERT_EQ(cloud.size(), 300u);
  EXPECT_NEAR(cloud.world(299).x, 512345.678 + 299, 1e-4);
  EXPECT_NEAR(cloud.world(299).y, 5423456.789, 1e-4);
}

TEST(Ply, keeps_all_digits_of_ascii_whatever_the_type) {
  const PointCloud cloud = read(ascii_xyz("498062.281 7050992.843 75.162\n498063 7050993 75\n"));
  EXPECT_EQ(cloud.origin, glm::dvec3(498062.281, 7050992.843, 75.0));
  EXPECT_NEAR(cloud.world(0).y, 7050992.843, 1e-6);
  EXPECT_NEAR(cloud.world(1).y, 7050993.0, 1e-6);
}

TEST(Ply, moves_floats_far_from_zero_to_their_corner_and_leaves_what_is_not_finite_there) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1003\nproperty float x\n"
      "property float y\nproperty float z\nend_header\n";
  const auto add = [&](float x, float y, float z) {
    for (const float v : {x, y, z}) text += bytes_of<float>(v, false);
  };
  // More than a block, which is looked at in another way if it has such points.
  for (int i = 0; i < 1000; ++i) add(100.0f + 0.001f * static_cast<float>(i), 7, 8);
  add(kInf, 7, 8);
  add(std::numeric_limits<float>::quiet_NaN(), -50, 8);
  add(101, 6, 9);
  const PointCloud cloud = read(text);
  EXPECT_EQ(cloud.origin, glm::dvec3(100, 6, 8));
  EXPECT_EQ(cloud.positions[0], glm::vec3(0, 1, 0));
  EXPECT_EQ(cloud.positions[1000].x, kInf);
  EXPECT_TRUE(std::isnan(cloud.positions[1001].x));
  EXPECT_EQ(cloud.positions[1002], glm::vec3(1, 0, 1));
}

TEST(Ply, keeps_points_that_are_not_finite_and_ignores_them_for_the_origin) {
  const PointCloud cloud = read(
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n100 7 7\nnan 0 0\n0 inf -9e999\n101 8 7\n");
  ASSERT_EQ(cloud.size(), 4u);
  EXPECT_EQ(cloud.origin, glm::dvec3(100, 7, 7));
  EXPECT_TRUE(std::isnan(cloud.positions[1].x));
  EXPECT_EQ(cloud.positions[2].z, -std::numeric_limits<float>::infinity());
  EXPECT_EQ(cloud.positions[3], glm::vec3(1, 1, 0));
}

TEST(Ply, ignores_values_beyond_float_for_the_origin) {
  const PointCloud cloud = read(
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
      "property double z\nend_header\n1000000.0001 7 7\n0 1e300 0\n1000001 8 7\n");
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_EQ(cloud.origin, glm::dvec3(1000000.0001, 7, 7));
  EXPECT_TRUE(std::isinf(cloud.positions[1].y));
}

PointCloud random_cloud(std::size_t n, const glm::dvec3& origin) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
  PointCloud cloud;
  cloud.origin = origin;
  for (std::size_t i = 0; i < n; ++i) {
    cloud.positions.emplace_back(uniform(random), uniform(random), uniform(random));
    cloud.normals.emplace_back(uniform(random), uniform(random), uniform(random));
    cloud.colors.emplace_back(random() & 0xffff, random() & 0xffff, random() & 0xffff);
    cloud.radii.push_back(uniform(random) + 2.0f);
  }
  return cloud;
}

std::string_view text_of(const Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(Ply, writes_and_reads_back_every_attribute_bit_by_bit) {
  const PointCloud cloud = random_cloud(1500, glm::dvec3(0));
  const Bytes bytes = ply_bytes(cloud);
  EXPECT_THAT(text_of(bytes), HasSubstr("property float x\n"));
  EXPECT_THAT(text_of(bytes), HasSubstr("property ushort red\n"));
  const PointCloud back = read(text_of(bytes));
  EXPECT_EQ(back.origin, cloud.origin);
  EXPECT_EQ(back.positions, cloud.positions);
  EXPECT_EQ(back.normals, cloud.normals);
  EXPECT_EQ(back.colors, cloud.colors);
  EXPECT_EQ(back.radii, cloud.radii);
}

TEST(Ply, writes_8_bit_colours_if_they_suffice) {
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {1, 0, 0}};
  cloud.colors = {{0, 257, 65535}, {514, 771, 25700}};
  const Bytes bytes = ply_bytes(cloud);
  EXPECT_THAT(text_of(bytes), HasSubstr("property uchar red\n"));
  EXPECT_EQ(read(text_of(bytes)).colors, cloud.colors);
}

TEST(Ply, writes_doubles_if_floats_would_lose_world_coordinates) {
  const PointCloud cloud = random_cloud(1500, glm::dvec3(4.5e6, -1e6, 1e3));
  const Bytes bytes = ply_bytes(cloud);
  EXPECT_THAT(text_of(bytes), HasSubstr("property double x\n"));
  const PointCloud back = read(text_of(bytes));
  ASSERT_EQ(back.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_LT(glm::length(back.world(i) - cloud.world(i)), 1e-6);
  }
  PointCloud exact;
  exact.origin = {1024, 0, 0};
  exact.positions = {{0.5f, 0, 0}, {0.25f, 1, 0}};
  EXPECT_THAT(text_of(ply_bytes(exact)), HasSubstr("property float x\n"));
  EXPECT_EQ(read(text_of(ply_bytes(exact))).world(1), exact.world(1));
}

TEST(Ply, writes_files_and_reports_failures) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "cloud.ply";
  const PointCloud cloud = random_cloud(10, glm::dvec3(0));
  ASSERT_TRUE(write_ply(path, cloud).has_value());
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(text, text_of(ply_bytes(cloud)));
  const Result<void> failed = write_ply("/no/such/folder/a.ply", cloud);
  ASSERT_FALSE(failed.has_value());
  EXPECT_EQ(failed.error().message,
            "/no/such/folder/a.ply: cannot be written: No such file or directory");
}

TEST(Ply, reads_or_refuses_every_truncation) {
  const Bytes whole = ply_bytes(random_cloud(20, glm::dvec3(0)));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    // The bytes are copied, so that the sanitizer notices reads past the end.
    const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const Result<PointCloud> cloud = read_ply(part);
    ASSERT_FALSE(cloud.has_value()) << size;
    EXPECT_TRUE(cloud.error().message.starts_with("line ") ||
                cloud.error().message.starts_with("byte "))
        << cloud.error().message;
  }
}

}  // namespace
}  // namespace pointreel::ply_test
