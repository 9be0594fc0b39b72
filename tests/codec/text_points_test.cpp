#include "codec/files/text_points.h"

#include <cmath>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pointreel::text_points_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

ByteView view(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

Result<PointCloud> read(const std::string& text, std::vector<std::string>* unread = nullptr) {
  ReadNotes notes;
  Result<PointCloud> cloud = read_text_points(ByteSource(view(text)), {}, notes);
  if (unread != nullptr) *unread = notes.unread;
  return cloud;
}

Result<PointCloud> read_as(const std::string& text, std::vector<std::string> columns,
                           std::vector<std::string>* warnings = nullptr) {
  ReadNotes notes;
  Result<PointCloud> cloud =
      read_text_points(ByteSource(view(text)), {std::move(columns), 0.0}, notes);
  if (warnings != nullptr) *warnings = notes.warnings;
  return cloud;
}

std::vector<std::string> guess(const std::vector<std::string>& texts, bool pts = false) {
  const std::vector<ByteView> views = [&] {
    std::vector<ByteView> all;
    for (const std::string& text : texts) all.push_back(view(text));
    return all;
  }();
  bool counts = false;
  return guess_text_columns(views, pts, counts);
}

bool first_column_counts(const std::string& text) {
  const ByteView bytes = view(text);
  bool counts = false;
  guess_text_columns({&bytes, 1}, false, counts);
  return counts;
}

std::string error_of(const std::string& text) {
  const Result<PointCloud> cloud = read(text);
  return cloud ? "it was read" : cloud.error().message;
}

TEST(TextPoints, points_at_zero_cost_the_others_no_digits_however_many_they_are) {
  for (const int zeros : {0, 100, 1500, 2990}) {  // first, as scans of the sky have them
    std::string text;
    for (int i = 0; i < 3000; ++i)
      text +=
          i < zeros ? "0 0 0\n" : fmt::format("{:.3f} 5423456.789 123.456\n", 512345.678 + i % 30);
    const Result<PointCloud> cloud = read(text);
    ASSERT_TRUE(cloud) << cloud.error().message;
    ASSERT_EQ(cloud->size(), 3000u);
    EXPECT_NEAR(cloud->world(2999).x, 512345.678 + 2999 % 30, 1e-4) << zeros;
    EXPECT_NEAR(cloud->world(2999).y, 5423456.789, 1e-4) << zeros;
    if (zeros > 0) {
      EXPECT_EQ(cloud->world(0), glm::dvec3(0.0)) << zeros;
    }
  }
}

TEST(TextPoints, small_objects_far_from_zero_keep_their_shape) {
  for (const double edge : {1e-3, 1e-5, 1e-9}) {
    std::string text;
    const auto at = [edge](int i) {
      return glm::dvec3(8.5417 + edge * (i % 10), 47.3769 + edge * (i / 10 % 10), edge * (i / 100));
    };
    for (int i = 0; i < 1000; ++i) {
      const glm::dvec3 p = at(i);
      text += fmt::format("{:.17g} {:.17g} {:.17g}\n", p.x, p.y, p.z);
    }
    const Result<PointCloud> cloud = read(text);
    ASSERT_TRUE(cloud) << cloud.error().message;
    for (std::size_t i = 0; i < cloud->size(); ++i)
      EXPECT_LT(glm::distance(cloud->world(i), at(static_cast<int>(i))), 1e-5 * edge + 2e-14)
          << edge << ' ' << i;
  }
}

TEST(TextPoints, numbers_may_be_separated_by_commas_semicolons_and_blanks) {
  for (const std::string text :
       {"1 2.5 3\n4 5 6\n", "  1\t2.5   3 \r\n4\t5\t6", "1,2.5,3\n4,5,6\n",
        "1, 2.5, 3,\n4, 5, 6,\n", "1;2.5;3\n4;5;6\n", "1;2,5;3\n4;5;6\n",
        "\"1\",\"2.5\",\"3\"\n4,5,6\n", "1 2.5 3\r4 5 6\r",
        "\xef\xbb\xbf"
        "1 2.5 3\n4 5 6\n",
        "# a comment\n\n1 2.5 3\n// another\n4 5 6\n%\n", "2\n1 2.5 3\n4 5 6\n",
        "1\t2,5\t3\n4\t5,0\t6\n", "1,0\t2,5\t3,00\n4\t5\t6\n", "1,0 2,5 3,0\n4,0 5,0 6,0\n"}) {
    const Result<PointCloud> cloud = read(text);
    ASSERT_TRUE(cloud) << text << cloud.error().message;
    ASSERT_EQ(cloud->size(), 2u) << text;
    EXPECT_EQ(cloud->world(0), glm::dvec3(1, 2.5, 3)) << text;
    EXPECT_EQ(cloud->world(1), glm::dvec3(4, 5, 6)) << text;
  }
}

TEST(TextPoints, a_header_names_the_columns_in_any_order) {
  for (const std::string head : {"intensity,blue,x,green,y,red,z\n", "//Intensity B X G Y R Z\n",
                                 "# intensity b x g y r z\n"}) {
    std::vector<std::string> unread;
    const Result<PointCloud> cloud = read(head + "9,30,1,20,2,10,3\n", &unread);
    ASSERT_TRUE(cloud) << cloud.error().message;
    EXPECT_EQ(cloud->world(0), glm::dvec3(1, 2, 3));
    EXPECT_THAT(cloud->colors, ElementsAre(glm::u16vec3(10 * 257, 20 * 257, 30 * 257)));
    ASSERT_EQ(cloud->scalars.size(), 1u);
    EXPECT_THAT(cloud->scalars[0].name, testing::StrCaseEq("intensity"));
    EXPECT_THAT(cloud->scalars[0].values, ElementsAre(9.0f));
    EXPECT_THAT(unread, IsEmpty());
  }
}

TEST(TextPoints, names_in_a_header_may_have_quotes_and_units) {
  for (const std::string head :
       {"X [mm],Y [mm],Z [mm],Intensity [%]\n", "\"x\",\"y\",\"z\",\"intensity\"\n",
        "x(m);y(m);z(m);intensity\n", "Points:0,Points:1,Points:2,intensity\n",
        "points_0,points_1,points_2,intensity\n",
        "\"Points_m_XYZ:0\",\"Points_m_XYZ:1\",\"Points_m_XYZ:2\",\"intensity\"\n"}) {
    SCOPED_TRACE(head);
    const std::string separator = head.find(';') == std::string::npos ? "," : ";";
    const Result<PointCloud> cloud =
        read(head + "1" + separator + "2" + separator + "3" + separator + "9\n");
    ASSERT_TRUE(cloud) << cloud.error().message;
    EXPECT_EQ(cloud->world(0), glm::dvec3(1, 2, 3));
    ASSERT_EQ(cloud->scalars.size(), 1u);
    EXPECT_THAT(cloud->scalars[0].name, testing::StrCaseEq("intensity"));
  }
}

TEST(TextPoints, paraview_numbers_the_columns_of_an_array) {
  const Result<PointCloud> cloud = read(
      "RGB:0,RGB:1,RGB:2,Normals_0,Normals_1,Normals_2,Points_0,Points_1,Points_2\n"
      "10,20,30,0,0,1,4,5,6\n");
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->world(0), glm::dvec3(4, 5, 6));
  EXPECT_EQ(cloud->colors.at(0), glm::u16vec3(10 * 257, 20 * 257, 30 * 257));
  EXPECT_EQ(cloud->normals.at(0), glm::vec3(0, 0, 1));
}

TEST(TextPoints, what_sensors_measure_comes_before_other_columns) {
  std::vector<std::string> unread;
  const Result<PointCloud> cloud = read(
      "Version,Slot,Lidar,Rsvd,Error,Type,Tag,Id,X,Y,Z,Reflectivity\n"
      "1,2,3,4,5,6,7,8,9,10,11,12\n",
      &unread);
  ASSERT_TRUE(cloud) << cloud.error().message;
  ASSERT_EQ(cloud->scalars.size(), kMaxScalars);
  EXPECT_EQ(cloud->scalars.back().name, "Reflectivity");
  EXPECT_THAT(cloud->scalars.back().values, ElementsAre(12.0f));
  EXPECT_THAT(unread, ElementsAre("Id"));
}

TEST(TextPoints, words_in_columns_that_are_not_read_do_no_harm) {
  const Result<PointCloud> cloud = read("name,x,y,z\nfloor,1,2,3\n,4,5,6\n");
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->world(1), glm::dvec3(4, 5, 6));
  EXPECT_TRUE(std::isnan(cloud->scalars.at(0).values.at(1)));
}

TEST(TextPoints, without_a_header_the_number_of_columns_decides) {
  const auto colors = ElementsAre(glm::u16vec3(10 * 257, 20 * 257, 30 * 257));
  const auto normals = ElementsAre(glm::vec3(0, 0, -1));
  EXPECT_THAT(read("1 2 3 50\n")->scalars, ElementsAre(ScalarField{"intensity", {50}}));
  EXPECT_THAT(read("1 2 3 10 20 30\n")->colors, colors);
  EXPECT_THAT(read("1 2 3 0 0 -1\n")->normals, normals);
  EXPECT_THAT(read("1 2 3 0.6 0.8 0\n")->normals, ElementsAre(glm::vec3(0.6f, 0.8f, 0)));
  EXPECT_THAT(read("1 2 3 10 20 30 0.5\n")->colors, colors);
  EXPECT_THAT(read("1 2 3 -1800 10 20 30\n")->colors, colors);  // as in .pts files
  const Result<PointCloud> both = read("1 2 3 10 20 30 0 0 -1 77\n");
  EXPECT_THAT(both->colors, colors);
  EXPECT_THAT(both->normals, normals);
  EXPECT_THAT(both->scalars, ElementsAre(ScalarField{"intensity", {77}}));
  EXPECT_THAT(read("1 2 3 4 5\n")->scalars,
              ElementsAre(ScalarField{"column 4", {4}}, ScalarField{"column 5", {5}}));
}

TEST(TextPoints, colors_and_normals_may_stand_in_either_order) {
  const auto columns = [](const std::string& line) {
    return fmt::format("{}", fmt::join(guess({line + "\n"}), " "));
  };
  EXPECT_EQ(columns("1 2 3 10 20 30 0.6 0 -0.8"), "x y z r g b nx ny nz");
  EXPECT_EQ(columns("1 2 3 0.6 0 -0.8 10 20 30"), "x y z nx ny nz r g b");
  EXPECT_EQ(columns("1 2 3 10 20 30 0.1 0.2 0.3"), "x y z r g b column 7 column 8 column 9");
  EXPECT_EQ(columns("1 2 3 10 20 30 0.6 0 -0.8 9"), "x y z r g b nx ny nz intensity");
  EXPECT_EQ(columns("1 2 3 10 20 30 9.5 0.6 0 -0.8"), "x y z r g b intensity nx ny nz");
  EXPECT_EQ(columns("1 2 3 0.6 0 -0.8 10 20 30 9.5"), "x y z nx ny nz r g b intensity");
  EXPECT_EQ(columns("1 2 3 0.6 0 -0.8 9.5 10 20 30"), "x y z nx ny nz intensity r g b");
  EXPECT_EQ(columns("1 2 3 110 120 130 7 8"), "x y z r g b column 7 column 8");
  EXPECT_EQ(columns("1 2 3 9.5 110 120 130 8"), "x y z intensity r g b column 8");
  EXPECT_EQ(columns("1 2 3 110 12 1 2 8"), "x y z column 4 column 5 column 6 column 7 column 8");
  EXPECT_EQ(columns("1 2 3 0.6 0 -0.8 9.5"), "x y z nx ny nz intensity");
  EXPECT_EQ(columns("1 2 3 9.5 0.6 0 -0.8"), "x y z intensity nx ny nz");
}

TEST(TextPoints, columns_are_guessed_once_for_all_files) {
  // Alone, the first would be read as colours and an intensity.
  const std::string dark = "1 2 3 7 0 0 0\n", bright = "1 2 3 0.5 10 20 30\n";
  EXPECT_THAT(guess({dark, bright}), ElementsAre("x", "y", "z", "intensity", "r", "g", "b"));
  EXPECT_THAT(guess({"1 2 3 0 0 0\n", "1 2 3 0 0 -1\n"}),
              ElementsAre("x", "y", "z", "nx", "ny", "nz"));
  EXPECT_THAT(guess({"x y z r g b\n1 2 3 4 5 6\n", "1 2 3 0 0 -1\n"}),
              ElementsAre("x", "y", "z", "r", "g", "b"));
  EXPECT_THAT(guess({"x y z r g b\n1 2 3 4 5 6\n"}), IsEmpty());
  EXPECT_THAT(guess({"not a point\n", ""}), IsEmpty());
}

TEST(TextPoints, columns_of_pts_files_have_an_order_of_their_own) {
  const std::string bytes = "1 2 3 7 10 20 30\n";
  EXPECT_THAT(guess({bytes}), ElementsAre("x", "y", "z", "r", "g", "b", "intensity"));
  for (const auto& columns : {guess({bytes}, true), guess({"1\n" + bytes})})
    EXPECT_THAT(columns, ElementsAre("x", "y", "z", "intensity", "r", "g", "b"));
  EXPECT_THAT(guess({"1\n1 2 3 1 0 0\n"}), ElementsAre("x", "y", "z", "r", "g", "b"));
  // CloudCompare writes the count, too, but in another order.
  for (const char* const scalar : {"-15.2", "0.5", "2000"}) {
    EXPECT_THAT(guess({fmt::format("1\n1 2 3 130 60 253 {}\n", scalar)}),
                ElementsAre("x", "y", "z", "r", "g", "b", "intensity"));
  }
  EXPECT_THAT(guess({"1\n1 2 3 7 0.6 0 -0.8\n"}),
              ElementsAre("x", "y", "z", "intensity", "nx", "ny", "nz"));
  EXPECT_THAT(guess({"1\n1 2 3 0.6 0 -0.8\n"}), ElementsAre("x", "y", "z", "nx", "ny", "nz"));
  EXPECT_THAT(guess({"1 2 3 7 10 20 30 0.6 0 -0.8\n"}, true),
              ElementsAre("x", "y", "z", "intensity", "r", "g", "b", "nx", "ny", "nz"));
  EXPECT_THAT(guess({"1 2 3 900 1000 2000 65535\n"}, true),
              ElementsAre("x", "y", "z", "intensity", "r", "g", "b"));
}

TEST(TextPoints, the_count_of_a_pts_file_is_compared_with_its_points) {
  std::vector<std::string> warnings;
  EXPECT_EQ(read_as("2\n1 2 3\n4 5 6\n", {"x", "y", "z"}, &warnings)->size(), 2u);
  EXPECT_THAT(warnings, IsEmpty());
  EXPECT_EQ(read_as("1\n1 2 3\n1\n4 5 6\n", {"x", "y", "z"}, &warnings)->size(), 2u);
  EXPECT_THAT(warnings, IsEmpty());
  EXPECT_EQ(read_as("3\n1 2 3\n4 5 6\n", {"x", "y", "z"}, &warnings)->size(), 2u);
  EXPECT_THAT(warnings, ElementsAre("says that it has 3 points, but there are 2"));
}

TEST(TextPoints, given_columns_hold_and_must_be_as_many) {
  const Result<PointCloud> cloud = read_as("1 2 3 4 5\n", {"y", "x", "_", "z", "time"});
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->world(0), glm::dvec3(2, 1, 4));
  EXPECT_THAT(cloud->scalars, ElementsAre(ScalarField{"time", {5}}));
  const Result<PointCloud> under_a_header = read_as("A,B,C\n1,2,3\n", {"x", "y", "z"});
  ASSERT_TRUE(under_a_header) << under_a_header.error().message;
  EXPECT_EQ(under_a_header->world(0), glm::dvec3(1, 2, 3));
  EXPECT_THAT(read("A,B,C\n1,2,3\n").error().message, HasSubstr("--columns names them"));
  EXPECT_THAT(read_as("1 2 3 4 5\n", {"x", "y", "z"}).error().message,
              HasSubstr("line 1: has 5 columns, but is to be read as x y z as the others"));
}

TEST(TextPoints, the_last_cell_may_be_empty_where_columns_have_names) {
  for (const char* text :
       {"x,y,z,heat\n0,0,0,5\n1,0,0,\n2,0,0,7\n", "x,y,z,heat\n1,0,0,\n0,0,0,5\n2,0,0,7\n"}) {
    std::vector<std::string> unread;
    const Result<PointCloud> cloud = read(text, &unread);
    ASSERT_TRUE(cloud) << cloud.error().message;
    ASSERT_EQ(cloud->scalars.size(), 1u);
    const std::vector<float>& heat = cloud->scalars[0].values;
    ASSERT_EQ(heat.size(), 3u);
    EXPECT_EQ(std::ranges::count_if(heat, [](float v) { return std::isnan(v); }), 1);
    EXPECT_EQ(heat[2], 7.0f);
    EXPECT_THAT(unread, testing::IsEmpty());
  }
  EXPECT_EQ(error_of("x,y,z\n1,2,3\n1,2,\n"), "line 3: has 2 columns, but the first point has 3");
}

TEST(TextPoints, large_numbers_that_differ_little_are_a_warning) {
  std::string text = "x,y,z,time,number,constant\n";
  for (int i = 0; i < 200; ++i)
    text += fmt::format("{},0,0,{:.4f},{},0.8\n", i, 1.7e9 + 0.0005 * i, 1000 + i);
  ReadNotes notes;
  ASSERT_TRUE(read_text_points(ByteSource(view(text)), {}, notes));
  EXPECT_THAT(notes.warnings,
              testing::ElementsAre("the scalar field time, from 1700000000 to 1700000000.1, is off "
                                   "by up to 0.0995, because it is kept in 32 bits: subtract an "
                                   "offset from it before"));
}

TEST(TextPoints, columns_of_words_are_named) {
  std::vector<std::string> unread;
  ASSERT_TRUE(read("x,y,z,label,heat\n0,0,0,wall,1\n1,0,0,floor,2\n", &unread));
  EXPECT_THAT(unread, testing::ElementsAre("label (words)"));
}

TEST(TextPoints, columns_that_only_later_lines_have_are_a_warning) {
  std::vector<std::string> warnings;
  EXPECT_EQ(read_as("1 2 3\n4 5 6 7\n1 2 3 # 4\n", {"x", "y", "z"}, &warnings)->size(), 3u);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("1 lines with more columns")));
}

TEST(TextPoints, colors_may_be_shares_bytes_or_words) {
  const auto color = [](const char* text) { return read(text)->colors.at(0); };
  EXPECT_EQ(color("x y z r g b\n1 2 3 1 0.5 0\n"), glm::u16vec3(65535, 32768, 0));
  EXPECT_EQ(color("x y z r g b\n1 2 3 255 0 0\n"), glm::u16vec3(65535, 0, 0));
  EXPECT_EQ(color("x y z r g b\n1 2 3 65535 0 256\n"), glm::u16vec3(65535, 0, 256));
}

TEST(TextPoints, rows_of_empty_cells_are_no_points) {
  const Result<PointCloud> cloud = read("x,y,z\n1,2,3\n,,\n4,5,6\n , ,\n");
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->size(), 2u);
  EXPECT_EQ(read(",,\nx,y,z\n,,\n1,2,3\n")->size(), 1u);
}

TEST(TextPoints, spreadsheets_name_their_separator_first) {
  const Result<PointCloud> cloud = read("sep=;\r\nx;y;z\r\n1,5;2;3\r\n");
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->world(0), glm::dvec3(1.5, 2, 3));
}

TEST(TextPoints, surveyors_call_a_position_easting_northing_and_elevation) {
  for (const char* const up : {"Elevation", "HEIGHT"}) {
    const Result<PointCloud> cloud = read(fmt::format("Northing,Easting,{}\n2,1,3\n5,4,6\n", up));
    ASSERT_TRUE(cloud) << cloud.error().message;
    EXPECT_EQ(cloud->world(0), glm::dvec3(1, 2, 3));
  }
  const Result<PointCloud> both = read("x,y,z,easting,northing,elevation\n1,2,3,7,8,9\n");
  EXPECT_EQ(both->world(0), glm::dvec3(1, 2, 3));
}

TEST(TextPoints, what_older_programs_of_windows_write_is_no_number) {
  const Result<PointCloud> cloud =
      read("x,y,z,intensity\n1,2,3,1.#QNAN\n4,5,6,7\n8,9,1,-1.#IND0000\n\x1a");
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->size(), 3u);
  EXPECT_TRUE(std::isnan(cloud->scalars.at(0).values.at(0)));
  EXPECT_EQ(cloud->scalars.at(0).values.at(1), 7.0f);
}

TEST(TextPoints, points_whose_position_is_missing_are_left_out) {
  for (const char* const missing : {"", "NA", "null", "nan"}) {
    const Result<PointCloud> cloud =
        read(fmt::format("x,y,z,r,g,b\n1,2,3,255,0,0\n{0},2,3,0,0,0\n4,5,6,{0},0,0\n", missing));
    ASSERT_TRUE(cloud) << cloud.error().message;
    ASSERT_EQ(cloud->size(), 3u) << "as the reader leaves them";
    EXPECT_TRUE(std::isnan(cloud->positions[1].x));
  }
}

TEST(TextPoints, files_of_most_columns_decide) {
  EXPECT_THAT(guess({"1 2 3\n", "1 2 3 4 5 6\n", "1 2 3 4 5 6\n"}),
              ElementsAre("x", "y", "z", "r", "g", "b"));
}

TEST(TextPoints, a_header_alone_is_a_cloud_without_points) {
  for (const char* const text : {"x y z\n", "//X Y Z R G B\n", "0\n"}) {
    const Result<PointCloud> cloud = read(text);
    ASSERT_TRUE(cloud) << cloud.error().message;
    EXPECT_EQ(cloud->size(), 0u);
  }
}

TEST(TextPoints, names_of_columns_that_are_not_there_are_a_warning) {
  std::vector<std::string> warnings;
  EXPECT_TRUE(read_as("x y z my field\n1 2 3 4\n", {}, &warnings));
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("names for 5 columns, but its points have 4")));
  EXPECT_TRUE(read_as("x y z my field\n1 2 3 4\n", {"x", "y", "z", "my_field"}, &warnings));
  EXPECT_THAT(warnings, IsEmpty());
}

TEST(TextPoints, points_of_colmap_end_in_lists) {
  std::vector<std::string> warnings;
  const Result<PointCloud> cloud = read_as(
      "# 3D point list with one line of data per point:\n"
      "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n"
      "# Number of points: 2, mean track length: 1.5\n"
      "7 1 2 3 10 20 30 0.5 1 2 3 4\n9 4 5 6 40 50 60 0.25 1 2\n",
      {}, &warnings);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->world(1), glm::dvec3(4, 5, 6));
  EXPECT_EQ(cloud->colors.at(1), glm::u16vec3(40 * 257, 50 * 257, 60 * 257));
  EXPECT_THAT(warnings, IsEmpty());
}

TEST(TextPoints, a_first_column_that_numbers_the_points_is_noticed) {
  std::string numbered, grid;
  for (int i = 0; i < 100; ++i) {
    numbered += fmt::format("{} 0.5 {} 7\n", i + 1, i % 9);
    grid += fmt::format("{} {} 0 7\n", i % 50, i / 50);
  }
  EXPECT_TRUE(first_column_counts(numbered));
  EXPECT_FALSE(first_column_counts(grid));
  EXPECT_FALSE(first_column_counts("0 0 0 1\n1 0 0 1\n2 0 0 1\n"));
}

TEST(TextPoints, errors_say_in_which_line_and_column) {
  EXPECT_THAT(error_of("hello, world\n"),
              HasSubstr("line 1: 'hello, world' is neither a point nor"));
  EXPECT_THAT(error_of("1 2 3\n4 five 6\n"), HasSubstr("line 2: 'five' in column 2"));
  EXPECT_THAT(error_of("1 2 3 4\n1 2 3\n"), HasSubstr("line 2: has 3 columns"));
  EXPECT_THAT(error_of("1 2\n"), HasSubstr("line 1: has 2 numbers"));
  EXPECT_THAT(error_of("x,y,z\n1,unknown,3\n"), HasSubstr("line 2: 'unknown' in column 2"));
  EXPECT_THAT(error_of("# nothing\n"), HasSubstr("no points"));
  EXPECT_THAT(error_of(std::string(3000, ',') + "\n"), HasSubstr("no points"));
  EXPECT_THAT(error_of("1 2 3\n1 2 \x1b[31m\n"), HasSubstr("'?[31m'"));
  EXPECT_THAT(error_of("\xff\xfe\x31"), HasSubstr("is UTF-16 text"));
}

TEST(TextPoints, more_columns_than_anybody_reads_take_no_memory) {
  std::string line;
  for (int i = 0; i < 5000; ++i) line += "1 ";
  std::vector<std::string> unread;
  const Result<PointCloud> cloud = read(line + "\n" + line + "\n", &unread);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->scalars.size(), kMaxScalars);
  EXPECT_THAT(unread, testing::Contains("column 12"));
  EXPECT_EQ(cloud->size(), 2u);
}

}  // namespace
}  // namespace pointreel::text_points_test
