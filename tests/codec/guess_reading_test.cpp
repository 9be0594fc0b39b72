#include "codec/files/guess_reading.h"

#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/files/full_color.h"
#include "codec/files/ply.h"
#include "codec/files/sample.h"
#include "common/base/concat.h"
#include "tests/temporary_folder.h"

namespace pointreel::guess_reading_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A frame of two points, whose brightest colour is given.
std::string ply(const std::string& type, double brightest) {
  return concat("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n",
                "property float z\nproperty ", type, " red\nproperty ", type, " green\nproperty ",
                type, " blue\nend_header\n1 2 3 0 0 0\n4 5 6 0 ", brightest, " 0\n");
}

std::string floats(const std::vector<float>& numbers) {
  std::string bytes(numbers.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

class GuessReading : public testing::Test {
 protected:
  CloudSequence list(const Reading& asked = {}) const {
    return list_cloud_frames({folder_.path()}, {.max_memory = ~std::uint64_t{0}, .reading = asked})
        .value();
  }

  std::vector<std::uint16_t> greens(const CloudSequence& sequence) const {
    std::vector<std::uint16_t> greens;
    for (const CloudFrame& frame : sequence.frames)
      greens.push_back(read_cloud_frame(frame).value().cloud.colors.at(1).y);
    return greens;
  }

  TemporaryFolder folder_;
};

TEST_F(GuessReading, a_dark_frame_has_the_range_of_colors_of_the_others) {
  for (const char* type : {"float", "ushort", "int"}) {
    const bool floats = type == std::string("float");
    const double dark = floats ? 1.5 : 100, bright = floats ? 255 : 65535;
    folder_.write("1.ply", ply(type, dark));
    folder_.write("2.ply", ply(type, bright));
    folder_.write("3.ply", ply(type, dark));
    const CloudSequence sequence = list();
    EXPECT_EQ(sequence.reading.full_color, bright) << type;
    // Integers of 16 bits usually end at 65535, which needs no word.
    EXPECT_EQ(sequence.guesses.size(), floats ? 1u : 0u) << type;
    const auto expected = static_cast<std::uint16_t>(dark / bright * 65535.0 + 0.5);
    EXPECT_THAT(greens(sequence), ElementsAre(expected, 65535, expected)) << type;
  }
}

TEST_F(GuessReading, colors_beyond_the_range_are_a_warning) {
  folder_.write("1.ply", ply("float", 1));
  folder_.write("2.ply", ply("float", 200));
  const CloudSequence sequence = list({{}, 1.0});
  EXPECT_THAT(sequence.guesses, IsEmpty());
  EXPECT_THAT(read_cloud_frame(sequence.frames[0])->warnings, IsEmpty());
  EXPECT_THAT(read_cloud_frame(sequence.frames[1])->warnings,
              ElementsAre(HasSubstr("colours up to 200, which are cut off at 1")));
}

TEST_F(GuessReading, colors_of_another_range_than_the_others_are_a_warning) {
  folder_.write("1.ply", ply("float", 200));
  folder_.write("2.ply", ply("float", 0.5));
  const CloudSequence sequence = list();
  EXPECT_EQ(sequence.reading.full_color, 255.0);
  EXPECT_THAT(read_cloud_frame(sequence.frames[1])->warnings,
              ElementsAre(HasSubstr("from 0 to 1, which are all but black, because 255")));
}

TEST_F(GuessReading, colors_whose_type_tells_their_range_are_not_guessed) {
  folder_.write("1.ply", ply("uchar", 1));
  folder_.write("2.ply", ply("uchar", 255));
  const CloudSequence sequence = list();
  EXPECT_EQ(sequence.reading.full_color, 0.0);
  EXPECT_THAT(sequence.guesses, IsEmpty());
  EXPECT_THAT(greens(sequence), ElementsAre(257, 65535));
}

TEST_F(GuessReading, sweeps_have_the_same_floats_in_all_frames) {
  for (std::size_t points = 40; points < 48; ++points) {
    std::vector<float> numbers;
    for (std::size_t i = 0; i < points; ++i) {
      const auto at = static_cast<float>(i);
      for (const float v : {at, 20.0f - at, 0.5f, 0.3f, 1e-4f * at}) numbers.push_back(v);
    }
    folder_.write(concat(points, ".bin"), floats(numbers));
  }
  const CloudSequence sequence = list();
  EXPECT_THAT(sequence.reading.columns, ElementsAre("x", "y", "z", "intensity", "time"));
  EXPECT_THAT(sequence.guesses, ElementsAre(HasSubstr("x y z intensity time (--columns")));
  for (std::size_t i = 0; i < sequence.frames.size(); ++i)
    EXPECT_EQ(read_cloud_frame(sequence.frames[i])->cloud.size(), 40 + i);
}

TEST_F(GuessReading, text_has_the_same_columns_in_all_frames_or_is_an_error_that_names_the_file) {
  folder_.write("1.pts", "1\n1 2 3 0 0 0 255\n");
  folder_.write("2.pts", "1\n1 2 3 9 255 0 0\n");
  folder_.write("3.pts", "1\n1 2 3 255 0 0\n");
  const CloudSequence sequence = list();
  EXPECT_THAT(read_cloud_frame(sequence.frames[0])->cloud.colors,
              ElementsAre(glm::u16vec3(0, 0, 65535)));
  EXPECT_THAT(read_cloud_frame(sequence.frames[1])->cloud.colors,
              ElementsAre(glm::u16vec3(65535, 0, 0)));
  EXPECT_THAT(read_cloud_frame(sequence.frames[2]).error().message,
              HasSubstr("3.pts: line 2: has 6 columns"));
}

TEST_F(GuessReading, only_fields_that_are_the_same_in_all_frames_say_nothing) {
  const auto write = [&](const char* name, int intensity, int first, int second) {
    folder_.write(name, concat("x,y,z,intensity,classification,alpha\n1,2,3,", intensity, ",",
                               first, ",255\n4,5,6,", intensity, ",", second, ",255\n"));
  };
  write("1.csv", 5, 2, 2);
  write("2.csv", 7, 2, 6);
  write("3.csv", 7, 2, 2);
  const auto fields = [&](const Reading& asked) {
    std::vector<std::size_t> fields;
    for (const CloudFrame& frame : list(asked).frames)
      fields.push_back(read_cloud_frame(frame).value().cloud.scalars.size());
    return fields;
  };
  EXPECT_THAT(fields({}), ElementsAre(2, 2, 2)) << "all but alpha";
  EXPECT_THAT(fields({{}, 0.0, std::vector<std::string>{}}), ElementsAre(3, 3, 3));
  EXPECT_THAT(fields({{}, 0.0, std::vector<std::string>{"classification"}}), ElementsAre(2, 3, 2));
  fs::remove(folder_ / "2.csv");
  fs::remove(folder_ / "3.csv");
  EXPECT_THAT(fields({}), ElementsAre(0));
}

TEST_F(GuessReading, fields_that_say_nothing_are_left_out_whatever_the_format_of_the_frames) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "property uchar alpha\nend_header\n1 2 3 0 0 0 255\n4 5 6 0 9 0 255\n";
  const std::string pcd =
      "VERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 2\n"
      "HEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 3 7\n4 5 6 7\n";
  for (const auto& [ending, text] : {std::pair("ply", ply), std::pair("pcd", pcd)}) {
    for (const char* const name : {"a/1.", "a/2.", "a/3."})
      folder_.write(name + std::string(ending), text);
    const auto sequence = list_cloud_frames({folder_ / "a"});
    ASSERT_TRUE(sequence) << sequence.error().message;
    ASSERT_EQ(sequence->frames.size(), 3u);
    for (const CloudFrame& frame : sequence->frames)
      EXPECT_THAT(read_cloud_frame(frame).value().cloud.scalars, IsEmpty()) << ending;
    fs::remove_all(folder_ / "a");
  }
}

TEST_F(GuessReading, what_was_asked_for_holds) {
  folder_.write("1.txt", "1 2 3 9 255 0 0\n");
  const CloudSequence sequence = list({{"z", "y", "x", "_", "b", "g", "r"}, 65535.0});
  EXPECT_THAT(sequence.guesses, IsEmpty());
  const PointCloud cloud = read_cloud_frame(sequence.frames[0]).value().cloud;
  EXPECT_EQ(cloud.world(0), glm::dvec3(3, 2, 1));
  EXPECT_THAT(cloud.colors, ElementsAre(glm::u16vec3(0, 0, 255)));
}

TEST_F(GuessReading, columns_are_of_no_use_where_files_name_their_fields) {
  folder_.write("1.ply", ply("uchar", 1));
  EXPECT_THAT(list({{"x", "y", "z"}, 0.0}).warnings,
              ElementsAre(HasSubstr("--columns is not used")));
}

TEST_F(GuessReading, a_single_file_is_guessed_in_the_same_way) {
  const auto loaded = read_cloud_file(folder_.write("a.pts", "1 2 3 7 255 0 0\n"));
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_THAT(loaded->cloud.colors, ElementsAre(glm::u16vec3(65535, 0, 0)));
}

TEST_F(GuessReading, files_that_follow_are_read_like_the_first) {
  Reading reading;
  folder_.write("1.ply", ply("float", 255));
  folder_.write("2.ply", ply("float", 1));
  ASSERT_TRUE(read_next_cloud_file(folder_ / "1.ply", reading));
  const auto second = read_next_cloud_file(folder_ / "2.ply", reading);
  ASSERT_TRUE(second) << second.error().message;
  EXPECT_EQ(second->cloud.colors.at(1).y, 257);
}

/// Samples of files of several MiB, in which only one piece in the middle is bright.
TEST(Sample, of_large_files_reads_like_the_file_and_has_points_from_all_over_it) {
  constexpr std::size_t kPoints = 200'000;
  std::string rows, text, lines;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const float bright = i > kPoints * 2 / 5 && i < kPoints * 3 / 5 ? 200.0f : 1.0f;
    rows += floats({1, 2, 3, bright, 0, 0});
    lines += concat("1 2 3 ", bright, " 0 0\n");
  }
  const auto header = [&](const char* format) {
    return concat("ply\nformat ", format, " 1.0\nelement vertex ", kPoints,
                  "\nproperty float x\nproperty float y\nproperty float z\nproperty float red\n",
                  "property float green\nproperty float blue\nend_header\n");
  };
  const std::string binary = header("binary_little_endian") + rows, ascii = header("ascii") + lines;
  const auto sampled = [](const std::string& file, CloudFormat format) {
    const ByteView bytes(reinterpret_cast<const std::uint8_t*>(file.data()), file.size());
    return sample_of(ByteSource(bytes), format).value().value();
  };
  for (const std::string* file : {&binary, &ascii}) {
    const Bytes sample = sampled(*file, CloudFormat::ply);
    EXPECT_LT(sample.size(), file->size() / 2);
    ReadNotes notes;
    const auto cloud = read_ply(sample, &notes);
    ASSERT_TRUE(cloud) << cloud.error().message;
    EXPECT_GT(cloud->size(), 10'000u);
    EXPECT_EQ(notes.full_color, 255.0);
  }
  const Bytes sample = sampled(lines, CloudFormat::text);
  EXPECT_LT(sample.size(), lines.size() / 2);
  const auto loaded = read_cloud(sample, CloudFormat::text);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->full_color, 255.0);
}

}  // namespace
}  // namespace pointreel::guess_reading_test
