#include "codec/files/obj.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pointreel::obj_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Result<PointCloud> read(const std::string& text) {
  ReadNotes notes;
  return read_obj(ByteSource({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}),
                  notes);
}

/// Of a file whose vertices are read nevertheless.
std::string warning_of(const std::string& text) {
  ReadNotes notes;
  const Result<PointCloud> cloud = read_obj(
      ByteSource({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}), notes);
  EXPECT_TRUE(cloud && cloud->size() == 1);
  return notes.warnings.size() == 1 ? notes.warnings[0] : "no warning";
}

std::string error_of(const std::string& text) {
  const Result<PointCloud> cloud = read(text);
  return cloud ? "it was read" : cloud.error().message;
}

TEST(Obj, vertices_may_have_colors_and_get_their_normals_from_faces) {
  const Result<PointCloud> cloud = read(
      "# a comment\nmtllib a.mtl\no thing\n"
      "v 0 0 0 1 0 0\nv 1 0 0 0 0.5 0\nv 0 1 0 0 0 1\nvt 0 0\nvn 0 0 1\nvn 1 0 0\n"
      "f 1/1/1 2//1 -1/1/-2\nf 1//2 2//1 3//1\nusemtl x\n");
  ASSERT_TRUE(cloud) << cloud.error().message;
  ASSERT_EQ(cloud->size(), 3u);
  EXPECT_EQ(cloud->world(1), glm::dvec3(1, 0, 0));
  EXPECT_THAT(cloud->colors, ElementsAre(glm::u16vec3(65535, 0, 0), glm::u16vec3(0, 32768, 0),
                                         glm::u16vec3(0, 0, 65535)));
  EXPECT_THAT(cloud->normals,
              ElementsAre(glm::vec3(1, 0, 1), glm::vec3(0, 0, 2), glm::vec3(0, 0, 2)));
}

TEST(Obj, without_faces_normals_belong_to_vertices_in_order) {
  const Result<PointCloud> cloud = read("v 0 0 0\nvn 0 0 1\nv 1 0 0\nvn 0 1 0\n");
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_THAT(cloud->normals, ElementsAre(glm::vec3(0, 0, 1), glm::vec3(0, 1, 0)));
  EXPECT_FALSE(read("v 0 0 0\nvn 0 0 1\nv 1 0 0\n")->has_normals());
}

TEST(Obj, a_weight_is_not_a_color_and_colors_count_if_all_have_one) {
  EXPECT_FALSE(read("v 1 2 3 1\n")->has_colors());
  EXPECT_EQ(read("v 1 2 3 1 1 0 0\n")->colors.at(0), glm::u16vec3(65535, 0, 0));
  EXPECT_FALSE(read("v 1 2 3 1 0 0\nv 1 2 3\n")->has_colors());
}

TEST(Obj, the_last_of_seven_numbers_is_an_opacity_unless_the_fourth_is_a_weight) {
  const auto colors = [](const std::string& text) { return read(text).value().colors; };
  const glm::u16vec3 red(65535, 0, 0), green(0, 65535, 0), blue(0, 0, 65535);
  EXPECT_THAT(colors("v 0 0 0 1 0 0 1\nv 1 0 0 0 1 0 1\n"), ElementsAre(red, green));
  EXPECT_THAT(colors("v 0 0 0 1 0 0 1\nv 1 0 0 1 0 1 0\n"), ElementsAre(blue, green));
  EXPECT_THAT(colors("v 0 0 0 1 0 0 1\nv 1 0 0 1 0 0 1\n"), ElementsAre(red, red));
}

TEST(Obj, the_first_vertex_may_stand_behind_a_utf8_mark) {
  const Result<PointCloud> cloud = read("\xef\xbb\xbfv 1 2 3\nv 4 5 6\n");
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->size(), 2u);
}

TEST(Obj, errors_say_in_which_line) {
  EXPECT_THAT(error_of("v 1 2\n"), HasSubstr("line 1: a vertex has 2 numbers"));
  EXPECT_THAT(error_of("\nv 1 x 3\n"), HasSubstr("line 2: 'x'"));
  EXPECT_THAT(error_of("v 1 2 3 4 5 6 7 8\n"), HasSubstr("more than 7"));
  EXPECT_THAT(error_of("vn 1 2\n"), HasSubstr("line 1: ''"));
}

TEST(Obj, wrong_faces_cost_a_warning_and_no_vertices) {
  EXPECT_THAT(warning_of("v 1 2 3\nvn 0 0 1\nf 2//1 1//1 1//1\n"), HasSubstr("the vertex '2'"));
  EXPECT_THAT(warning_of("v 1 2 3\nvn 0 0 1\nf 1//-2\n"), HasSubstr("the normal '-2'"));
  EXPECT_THAT(warning_of("v 1 2 3\nvn 0 0 1\nf 0//1\n"), HasSubstr("the vertex '0'"));
  EXPECT_THAT(warning_of("v 1 2 3\nf 1//1\nf 1//1\n"),
              HasSubstr("line 2: a face refers to the normal '1', but there are 0 so far; 2 such"));
  EXPECT_THAT(warning_of("v 1 2 3\nvn 0 0 1\nf 99999999999999999999//1\n"), HasSubstr("refers"));
}

}  // namespace
}  // namespace pointreel::obj_test
