#include "codec/files/point_cloud2.h"

#include <cmath>
#include <cstring>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/ros_messages.h"

namespace pointreel::point_cloud2_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Result<PointCloud> read(const Bytes& bytes, std::vector<std::string>* unread = nullptr) {
  ReadNotes notes;
  const Result<PointCloud> cloud = read_point_cloud2(ByteSource(ByteView(bytes)), notes);
  if (unread != nullptr) *unread = notes.unread;
  return cloud;
}

std::string error_of(const CloudMessage& message) {
  const Result<PointCloud> cloud = read(message.cdr());
  return cloud ? "it was read" : cloud.error().message;
}

TEST(PointCloud2, both_byte_orders_give_the_same_points) {
  for (const bool big : {false, true}) {
    CloudMessage message = two_points();
    message.big_endian = big;
    std::vector<std::string> unread;
    const Result<PointCloud> cloud = read(message.cdr(), &unread);
    ASSERT_TRUE(cloud) << cloud.error().message;
    ASSERT_EQ(cloud->size(), 2u);
    EXPECT_EQ(cloud->world(0), glm::dvec3(1, 2, 3));
    EXPECT_EQ(cloud->world(1), glm::dvec3(4, 5, 6));
    EXPECT_THAT(cloud->colors, ElementsAre(glm::u16vec3(257 * 0x10, 257 * 0x20, 257 * 0x30),
                                           glm::u16vec3(257 * 0x10, 257 * 0x20, 257 * 0x30)));
    EXPECT_THAT(cloud->scalars, ElementsAre(ScalarField{"intensity", {77, 77}}));
    EXPECT_THAT(unread, ElementsAre("histogram"));
  }
}

TEST(PointCloud2, rows_may_be_padded) {
  CloudMessage message = two_points();
  message.width = 1;
  message.height = 2;
  message.row_step = message.point_step + 5;
  message.row_padding = 5;
  const Result<PointCloud> cloud = read(message.cdr());
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->world(1), glm::dvec3(4, 5, 6));
}

TEST(PointCloud2, rows_follow_each_other_where_row_step_is_0) {
  CloudMessage message = two_points();
  message.width = 1;
  message.height = 2;
  message.row_step = 0;
  const Result<PointCloud> cloud = read(message.cdr());
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->world(1), glm::dvec3(4, 5, 6));
}

TEST(PointCloud2, a_count_of_0_stands_for_1) {
  CloudMessage message = two_points();
  for (auto& field : message.fields) field.count = field.count == 1 ? 0 : field.count;
  std::vector<std::string> unread;
  const Result<PointCloud> cloud = read(message.cdr(), &unread);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->world(1), glm::dvec3(4, 5, 6));
  EXPECT_THAT(cloud->scalars, ElementsAre(ScalarField{"intensity", {77, 77}}));
  EXPECT_THAT(unread, ElementsAre("histogram"));
}

TEST(PointCloud2, fields_without_a_name_are_told_as_such) {
  CloudMessage message = two_points();
  message.fields[2].name = "";
  std::vector<std::string> unread;
  ASSERT_TRUE(read(message.cdr(), &unread));
  EXPECT_THAT(unread, ElementsAre("(unnamed)", "histogram"));
}

TEST(PointCloud2, a_cloud_without_points_is_no_error) {
  CloudMessage message = two_points();
  message.points.clear();
  message.width = 0;
  message.point_step = 0;
  message.fields.clear();
  const Result<PointCloud> cloud = read(message.cdr());
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_TRUE(cloud->empty());
}

TEST(PointCloud2, each_lie_of_the_message_is_an_error_that_names_the_member) {
  const auto with = [](auto change) {
    CloudMessage message = two_points();
    change(message);
    return error_of(message);
  };
  EXPECT_THAT(with([](auto& m) { m.point_step = 0; }), HasSubstr("point_step: is 0"));
  EXPECT_THAT(with([](auto& m) { m.point_step = 8; }), HasSubstr("ends after point_step"));
  EXPECT_THAT(with([](auto& m) { m.fields[0].offset = ~0u; }), HasSubstr("ends after point_step"));
  EXPECT_THAT(with([](auto& m) { m.fields[0].type = 9; }), HasSubstr("type of z does not exist"));
  EXPECT_THAT(with([](auto& m) { m.fields[0].name = "w"; }), HasSubstr("no field z"));
  EXPECT_THAT(with([](auto& m) { m.width = 3; }), HasSubstr("data: has"));
  EXPECT_THAT(with([](auto& m) { m.width = m.height = m.row_step = ~0u; }), HasSubstr("row_step"));
  EXPECT_THAT(with([](auto& m) {
                m.height = ~0u;
                m.row_step = ~0u;
              }),
              HasSubstr("data: has"));
  EXPECT_THAT(with([](auto& m) {
                m.height = 2;
                m.row_step = 1;
              }),
              HasSubstr("row_step: is 1"));
  EXPECT_THAT(with([](auto& m) { m.fields.resize(2000, m.fields[0]); }), HasSubstr("fields: has"));
}

TEST(PointCloud2, any_part_of_a_message_is_refused_in_one_line) {
  const Bytes whole = two_points().cdr();
  for (std::size_t size = 0; size < whole.size() - 1; ++size) {
    const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const Result<PointCloud> cloud = read(part);
    ASSERT_FALSE(cloud) << size;
    EXPECT_EQ(cloud.error().message.find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace pointreel::point_cloud2_test
