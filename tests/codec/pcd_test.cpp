#include "codec/files/pcd.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lzf.h>

#include "codec/files/words.h"
#include "tests/view.h"

namespace pointreel::pcd_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Result<PointCloud> read(const std::string& text, std::vector<std::string>* unread = nullptr) {
  ReadNotes notes;
  const Result<PointCloud> cloud = read_pcd(ByteSource(view(text)), notes);
  if (unread != nullptr) *unread = notes.unread;
  return cloud;
}

std::string error_of(const std::string& text) {
  const Result<PointCloud> cloud = read(text);
  return cloud ? "it was read" : cloud.error().message;
}

template <class T>
void put(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// Two points with colours, normals and what else PCL writes.
const std::string kHead =
    "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
    "FIELDS x y z rgb normal_x normal_y normal_z curvature\n"
    "SIZE 4 4 4 4 4 4 4 4\nTYPE F F F F F F F F\nCOUNT 1 1 1 1 1 1 1 1\n"
    "WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\n";

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

std::string ascii() {
  const auto rgb = std::bit_cast<float>(0x00ff8001u);
  return kHead + "DATA ascii\n1 2 3 " + number_text(rgb) + " 0 0 1 0.5\n4 5 6 " +
         std::to_string(0x0000ff) + " 0 1 0 0.25\n";
}

std::string records() {
  std::string data;
  for (int i = 0; i < 2; ++i) {
    for (int axis = 0; axis < 3; ++axis) put(data, static_cast<float>(3 * i + axis + 1));
    put(data, i == 0 ? 0x00ff8001u : 0x000000ffu);
    for (const float n : {0.0f, i == 0 ? 0.0f : 1.0f, i == 0 ? 1.0f : 0.0f}) put(data, n);
    put(data, 0.5f / static_cast<float>(i + 1));
  }
  return data;
}

std::string compressed(const std::string& columns) {
  std::string packed(2 * columns.size() + 64, '\0');
  packed.resize(lzf_compress(columns.data(), static_cast<unsigned>(columns.size()), packed.data(),
                             static_cast<unsigned>(packed.size())));
  std::string data;
  put(data, static_cast<std::uint32_t>(packed.size()));
  put(data, static_cast<std::uint32_t>(columns.size()));
  return data + packed;
}

/// Records of numbers of four bytes as columns.
std::string columns_of(const std::string& rows, std::size_t count) {
  const std::size_t fields = rows.size() / count / 4;
  std::string columns;
  for (std::size_t field = 0; field < fields; ++field)
    for (std::size_t row = 0; row < count; ++row)
      columns += rows.substr(4 * (row * fields + field), 4);
  return columns;
}

void expect_two_points(const std::string& text) {
  std::vector<std::string> unread;
  const Result<PointCloud> cloud = read(text, &unread);
  ASSERT_TRUE(cloud) << cloud.error().message;
  ASSERT_EQ(cloud->size(), 2u);
  EXPECT_EQ(cloud->world(0), glm::dvec3(1, 2, 3));
  EXPECT_EQ(cloud->world(1), glm::dvec3(4, 5, 6));
  EXPECT_THAT(cloud->colors,
              ElementsAre(glm::u16vec3(255 * 257, 128 * 257, 257), glm::u16vec3(0, 0, 255 * 257)));
  EXPECT_THAT(cloud->normals, ElementsAre(glm::vec3(0, 0, 1), glm::vec3(0, 1, 0)));
  EXPECT_THAT(cloud->scalars, ElementsAre(ScalarField{"curvature", {0.5f, 0.25f}}));
  EXPECT_THAT(unread, IsEmpty());
}

TEST(Pcd, unknown_lines_cost_a_warning_and_case_does_not_matter) {
  std::string text = ascii();
  text.insert(text.find("VIEWPOINT"), "METADATA {\"sensor\":1}\n");
  text.replace(text.find("FIELDS x"), 8, "Fields X");
  text.replace(text.find("DATA ascii"), 10, "data ASCII");
  ReadNotes notes;
  const Result<PointCloud> cloud = read_pcd(ByteSource(view(text)), notes);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->world(1), glm::dvec3(4, 5, 6));
  EXPECT_THAT(notes.warnings, ElementsAre("line 9: is skipped: unknown keyword 'METADATA'"));
}

TEST(Pcd, ascii_binary_and_compressed_files_give_the_same_points) {
  expect_two_points(ascii());
  expect_two_points(kHead + "DATA binary\n" + records());
  expect_two_points(kHead + "DATA binary_compressed\n" + compressed(columns_of(records(), 2)));
}

TEST(Pcd, fields_may_have_any_order_size_and_type) {
  std::string text =
      "VERSION .7\nFIELDS label z _ y histogram x rgba ignored\nSIZE 2 8 1 4 4 2 4 8\n"
      "TYPE U F U I F I U I\nCOUNT 1 1 3 1 2 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA binary\n";
  put(text, std::uint16_t{7});
  put(text, 3.5);
  text += "abc";
  put(text, std::int32_t{-2});
  put(text, 1.0f);
  put(text, 2.0f);
  put(text, std::int16_t{-1});
  put(text, 0xff0a0b0cu);
  put(text, std::int64_t{5});
  std::vector<std::string> unread;
  const Result<PointCloud> cloud = read(text, &unread);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->world(0), glm::dvec3(-1, -2, 3.5));
  EXPECT_THAT(cloud->colors, ElementsAre(glm::u16vec3(0x0a * 257, 0x0b * 257, 0x0c * 257)));
  EXPECT_THAT(cloud->scalars, ElementsAre(ScalarField{"label", {7}}, ScalarField{"ignored", {5}}));
  EXPECT_THAT(unread, ElementsAre("histogram"));
}

TEST(Pcd, points_that_were_not_measured_remain_for_sanitize) {
  const Result<PointCloud> cloud = read(
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 1\n"
      "DATA ascii\nnan nan nan\n1 2 3\n");
  ASSERT_TRUE(cloud) << cloud.error().message;
  ASSERT_EQ(cloud->size(), 2u);
  EXPECT_TRUE(std::isnan(cloud->positions[0].x));
  EXPECT_EQ(cloud->world(1), glm::dvec3(1, 2, 3));
}

TEST(Pcd, a_viewpoint_does_not_move_the_points_and_is_named) {
  std::string text = ascii();
  text.replace(text.find("VIEWPOINT 0 0 0"), 15, "VIEWPOINT 5 0 0");
  std::vector<std::string> unread;
  const Result<PointCloud> cloud = read(text, &unread);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->world(0), glm::dvec3(1, 2, 3));
  EXPECT_THAT(unread, ElementsAre("VIEWPOINT"));
}

TEST(Pcd, coordinates_far_from_zero_get_an_origin) {
  std::string text =
      "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nDATA binary\n";
  for (const double v : {500000.125, 5400000.001, 100.0, 500001.125, 5400002.002, 101.0})
    put(text, v);
  const Result<PointCloud> cloud = read(text);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_NEAR(cloud->world(1).y, 5400002.002, 1e-6);
}

TEST(Pcd, an_empty_cloud_is_no_error) {
  for (const char* data : {"ascii", "binary"}) {
    const Result<PointCloud> cloud =
        read(std::string("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 0\nHEIGHT 1\n"
                         "POINTS 0\nDATA ") +
             data + "\n");
    ASSERT_TRUE(cloud) << cloud.error().message;
    EXPECT_THAT(cloud->positions, IsEmpty());
  }
}

/// The file with a part of it replaced.
std::string changed(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(Pcd, each_lie_of_the_header_is_an_error_that_says_where) {
  EXPECT_THAT(error_of(changed(ascii(), "POINTS 2", "POINTS 3")),
              HasSubstr("POINTS 3, but WIDTH times HEIGHT is 2"));
  EXPECT_THAT(error_of(changed(ascii(), "WIDTH 2", "WIDTH x")), HasSubstr("line 7: WIDTH has 'x'"));
  EXPECT_THAT(error_of(changed(ascii(), "WIDTH 2\nHEIGHT 1\n",
                               "WIDTH 1099511627776\n"
                               "HEIGHT 1099511627776\n")),
              HasSubstr("too large"));
  EXPECT_THAT(error_of(changed(ascii(), "SIZE 4 4", "SIZE 4")), HasSubstr("line 4: SIZE has 7"));
  EXPECT_THAT(error_of(changed(ascii(), "SIZE 4", "SIZE 4 4")), HasSubstr("more entries"));
  EXPECT_THAT(error_of(changed(ascii(), "SIZE 4", "SIZE 3")), HasSubstr("field x has the type F"));
  EXPECT_THAT(error_of(changed(ascii(), "TYPE F", "TYPE Q")), HasSubstr("'Q'"));
  EXPECT_THAT(error_of(changed(ascii(), "COUNT 1", "COUNT 99999999")), HasSubstr("2^20"));
  EXPECT_THAT(error_of(changed(ascii(), "FIELDS x", "FIELDS w")), HasSubstr("no field x"));
  EXPECT_THAT(error_of(changed(ascii(), "DATA ascii", "DATA morse")), HasSubstr("'morse'"));
  EXPECT_THAT(error_of(changed(ascii(), "DATA ascii\n", "")), HasSubstr("no line DATA"));
  EXPECT_THAT(error_of(changed(ascii(), "4 5 6", "4 five 6")),
              HasSubstr("line 13: y of point 1 is 'five'"));
  EXPECT_THAT(error_of(changed(ascii(), " 0.25\n", "\n")),
              HasSubstr("the data end before curvature of point 1 of 2"));
  const std::string many =
      changed(kHead, "WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2", "WIDTH 1000000000000");
  EXPECT_THAT(error_of(many + "DATA ascii\n1 2"), HasSubstr("the data end"));
  EXPECT_THAT(error_of(many + "DATA binary\n" + records()), HasSubstr("within point 2 of"));
  EXPECT_THAT(error_of(many + "DATA binary_compressed\n" + compressed(columns_of(records(), 2))),
              HasSubstr("the columns take 64 bytes, but"));
}

TEST(Pcd, damaged_columns_are_an_error) {
  const std::string head = kHead + "DATA binary_compressed\n";
  const std::string data = compressed(columns_of(records(), 2));
  EXPECT_THAT(error_of(head + data.substr(0, 5)), HasSubstr("within their sizes"));
  EXPECT_THAT(error_of(head + data.substr(0, data.size() - 1)), HasSubstr("end before"));
  std::string short_of_bytes = data;
  const std::uint32_t less = 20;
  std::memcpy(short_of_bytes.data(), &less, 4);
  EXPECT_THAT(error_of(head + short_of_bytes), HasSubstr("damaged"));
  // One byte cannot stand for a thousand points.
  std::string bomb = changed(changed(kHead, "WIDTH 2", "WIDTH 1000"), "POINTS 2", "POINTS 1000") +
                     "DATA binary_compressed\n";
  put(bomb, std::uint32_t{1});
  put(bomb, std::uint32_t{32000});
  EXPECT_THAT(error_of(bomb + "x"), HasSubstr("cannot stand for"));
}

TEST(Pcd, any_part_of_a_file_is_read_or_refused_in_one_line) {
  for (const std::string& text :
       {ascii(), kHead + "DATA binary\n" + records(),
        kHead + "DATA binary_compressed\n" + compressed(columns_of(records(), 2))}) {
    for (std::size_t size = 0; size + 8 < text.size(); ++size) {
      const Result<PointCloud> cloud = read(text.substr(0, size));
      ASSERT_FALSE(cloud) << size;
      EXPECT_EQ(cloud.error().message.find('\n'), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace pointreel::pcd_test
