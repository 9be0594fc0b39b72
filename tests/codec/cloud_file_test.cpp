#include "codec/files/cloud_file.h"

#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "codec/draco/draco_payload.h"
#include "codec/files/cloud_folder.h"
#include "codec/files/ply.h"
#include "codec/package/manifest.h"
#include "tests/paths.h"
#include "tests/temporary_folder.h"
#include "tests/unprivileged.h"
#include "tests/view.h"

namespace pointreel::cloud_file_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

class CloudFile : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& content) const {
    return folder_.write(name, content);
  }
  fs::path write(const std::string& name, const Bytes& content) const {
    return write(name, std::string(content.begin(), content.end()));
  }

  TemporaryFolder folder_;
};

const std::string kPly =
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
    "property float z\nend_header\n1 2 3\n4 5 6\n";

Bytes drc() {
  PointCloud cloud;
  cloud.positions = {{1, 1, 1}, {2, 2, 2}};
  // A payload's positions are the centres of cells, counted from the corner of the cube. Here a
  // cell has edge 1.
  return *encode_draco_payload(cloud, Cube{glm::dvec3(0.0), 2048.0}, {}, false, false);
}

std::vector<std::string> names(const std::vector<fs::path>& paths) {
  std::vector<std::string> out;
  for (const fs::path& path : paths) out.push_back(path.filename().string());
  return out;
}

TEST_F(CloudFile, formats_are_recognised_by_their_first_bytes_and_not_by_file_names) {
  const auto ply = read_cloud_file(write("cloud.drc", kPly));
  ASSERT_TRUE(ply) << ply.error().message;
  EXPECT_EQ(ply->cloud.world(1), glm::dvec3(4, 5, 6));
  EXPECT_TRUE(ply->warnings.empty());
  const auto draco = read_cloud_file(write("cloud.ply", drc()));
  ASSERT_TRUE(draco) << draco.error().message;
  ASSERT_EQ(draco->cloud.size(), 2u);
  EXPECT_EQ(draco->cloud.world(0), glm::dvec3(1.5));
}

TEST_F(CloudFile, repairs_are_described_in_words) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
      "property float radius\nend_header\n";
  const auto loaded = read_cloud(view(header + "nan 0 0 1 0 0 1\n"
                                               "0 inf 0 1 0 0 1\n"
                                               "1 2 3 0 0 0 1\n"
                                               "4 5 6 0 0 2 -1\n"));
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->cloud.size(), 2u);
  EXPECT_EQ(loaded->cloud.normals[1], glm::vec3(0, 0, 1));
  EXPECT_THAT(loaded->warnings, ElementsAre(HasSubstr("dropped 2 points without a finite position"),
                                            "1 point has no usable normal: it is estimated",
                                            "replaced 1 unusable radius value"));
}

/// A sphere with its normals, whose first ones are replaced.
PointCloud sphere_with(std::size_t unusable, const glm::vec3& normal) {
  constexpr std::size_t kCount = 2000;
  PointCloud cloud;
  for (std::size_t i = 0; i < kCount; ++i) {
    const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / kCount;
    const double angle = 2.399963 * static_cast<double>(i), r = std::sqrt(1.0 - z * z);
    cloud.positions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    cloud.normals.push_back(i < unusable ? normal : cloud.positions.back());
  }
  return cloud;
}

TEST_F(CloudFile, normals_that_say_nothing_are_estimated) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const glm::vec3& normal : {glm::vec3(0.0f), glm::vec3(nan, 0, 1)}) {
    const PointCloud source = sphere_with(700, normal);
    const LoadedCloud loaded = usable_cloud(source, CloudFormat::ply);
    ASSERT_EQ(loaded.cloud.normals.size(), source.size());
    for (std::size_t i = 0; i < source.size(); ++i) {
      EXPECT_GT(glm::dot(loaded.cloud.normals[i], source.positions[i]), i < 700 ? 0.95f : 0.99999f);
    }
    EXPECT_THAT(loaded.warnings, ElementsAre("700 points have no usable normal: it is estimated"));
  }
  const LoadedCloud none = usable_cloud(sphere_with(2000, glm::vec3(0.0f)), CloudFormat::ply);
  EXPECT_FALSE(none.cloud.has_normals());
  EXPECT_THAT(none.warnings, ElementsAre(HasSubstr("normals are taken to be missing")));
  const LoadedCloud all = usable_cloud(sphere_with(0, glm::vec3(0.0f)), CloudFormat::ply);
  EXPECT_THAT(all.warnings, testing::IsEmpty());
}

TEST_F(CloudFile, numbers_that_are_the_same_everywhere_and_say_nothing_are_no_scalar_fields) {
  PointCloud source;
  source.positions = {{0, 0, 0}, {1, 1, 1}};
  source.scalars = {{"alpha", {255, 255}},         {"Intensity", {0, 0}},
                    {"scalar_Intensity", {1, 2}},  {"return number", {1, 1}},
                    {"Number_Of_Returns", {1, 1}}, {"label", {3, 3}}};
  const LoadedCloud loaded = usable_cloud(source, CloudFormat::ply);
  ASSERT_EQ(loaded.cloud.scalars.size(), 2u);
  EXPECT_EQ(loaded.cloud.scalars[0].name, "scalar_Intensity");
  EXPECT_EQ(loaded.cloud.scalars[1].name, "label");
  EXPECT_THAT(loaded.unread,
              ElementsAre("alpha (the same at all points)", "Intensity (the same at all points)",
                          "return number (the same at all points)",
                          "Number_Of_Returns (the same at all points)"));
}

TEST_F(CloudFile, points_at_zero_far_from_all_others_are_left_out) {
  PointCloud source = sphere_with(0, glm::vec3(0.0f));
  for (const glm::dvec3& origin : {glm::dvec3(500000.3, 5400000.7, 30), glm::dvec3(0, -40, 0)}) {
    PointCloud cloud = source;
    cloud.origin = origin;
    for (const std::size_t i : {7, 9, 1000}) cloud.positions[i] = glm::vec3(-origin);
    const LoadedCloud loaded = usable_cloud(cloud, CloudFormat::ply);
    EXPECT_EQ(loaded.cloud.size(), 1997u);
    EXPECT_EQ(loaded.cloud.normals.size(), 1997u);
    EXPECT_EQ(loaded.left_out, 3u);
    EXPECT_THAT(
        loaded.warnings,
        ElementsAre("left out 3 points at 0 0 0, far from all others; the first is point 7"));
  }
  source.positions[7] = glm::vec3(0.0f);  // within the others
  EXPECT_EQ(usable_cloud(source, CloudFormat::ply).cloud.size(), 2000u);
  source.origin = {0, -20, 0};
  source.positions[7] = {0, 20, 0};  // not far enough
  EXPECT_EQ(usable_cloud(source, CloudFormat::ply).cloud.size(), 2000u);
}

TEST_F(CloudFile, missing_numbers_of_frames_are_named_and_their_time_can_be_kept) {
  for (const char* name : {"f1.ply", "f2.ply", "F3.ply", "f6.ply", "f7.ply", "f9.ply"})
    write(name, kPly);
  auto sequence = list_cloud_frames({folder_.path()});
  ASSERT_TRUE(sequence) << sequence.error().message;
  EXPECT_THAT(sequence->warnings,
              ElementsAre(HasSubstr("judging by their numbers, 3 frames are missing: 4 to 5, 8")));
  EXPECT_THAT(sequence->times_us, testing::IsEmpty());
  sequence->keep_gaps(10.0);
  EXPECT_THAT(sequence->times_us, ElementsAre(0, 100'000, 200'000, 500'000, 600'000, 800'000));
  EXPECT_EQ(sequence->end_us(), 900'000u);
  EXPECT_EQ(sequence->fps, 10.0) << "also where most intervals are gaps";
  EXPECT_THAT(sequence->warnings, ElementsAre(testing::EndsWith(": 4 to 5, 8")));
  fs::remove(folder_ / "f9.ply");
  for (const char* name : {"f4.ply", "f5.ply"}) write(name, kPly);
  EXPECT_THAT(list_cloud_frames({folder_.path()})->warnings, testing::IsEmpty());
  EXPECT_THAT(list_cloud_frames({folder_.path()}, {.topic = "/points"})->warnings,
              ElementsAre("--topic is not used: there is no MCAP recording"));
}

TEST_F(CloudFile, frames_that_are_not_seen_because_the_next_has_their_time_are_counted) {
  CloudSequence sequence;
  for (const std::uint64_t time : {0u, 100'000u, 100'000u, 200'000u, 300'000u})
    sequence.frames.emplace_back().time_us = time;
  sequence.find_times();
  EXPECT_THAT(sequence.times_us, ElementsAre(0, 100'000, 100'000, 200'000, 300'000));
  EXPECT_THAT(sequence.warnings, ElementsAre(HasSubstr("1 of 5 frames have the same time as the")));
}

TEST_F(CloudFile, times_that_are_not_believed_are_named) {
  const auto warnings = [](const std::vector<std::uint64_t>& times) {
    CloudSequence sequence;
    for (const std::uint64_t time : times) {
      CloudFrame& frame = sequence.frames.emplace_back();
      frame.file = fmt::format("{}.bin", sequence.frames.size());
      frame.time_us = time;
    }
    sequence.find_times();
    EXPECT_EQ(sequence.times_us.empty(), !sequence.warnings.empty());
    return sequence.warnings;
  };
  EXPECT_THAT(warnings({5, 6, 8}), testing::IsEmpty());
  EXPECT_THAT(warnings({5, 8, 6}), ElementsAre(StartsWith("3.bin: its time is before that of")));
  EXPECT_THAT(warnings({5, 4}), ElementsAre(StartsWith("2.bin: its time is before that of")));
  EXPECT_THAT(warnings({0, 1'700'000'000'000'000, 1'700'000'000'100'000}),
              ElementsAre(StartsWith("2.bin: its time is more than 31 days after the first")));
  EXPECT_THAT(warnings({5, 5, 5}), ElementsAre(StartsWith("most frames have the time of")));
}

TEST_F(CloudFile, text_beside_scans_is_no_frame) {
  folder_.write("scans/a.csv", "x,y,z\n1,2,3\n");
  folder_.write("scans/timestamps.csv", "time\n1\n");
  const auto sequence = list_cloud_frames({folder_ / "scans"});
  ASSERT_TRUE(sequence) << sequence.error().message;
  EXPECT_EQ(sequence->frames.size(), 1u);
  EXPECT_THAT(sequence->warnings, ElementsAre(HasSubstr("timestamps.csv: is left out")));
  folder_.write("kitti/calib.txt", "P0: 1 2 3\n");
  folder_.write("kitti/velodyne/000000.bin", std::string(32, '\0'));
  EXPECT_FALSE(has_cloud_files(folder_ / "kitti"));
  EXPECT_THAT(list_cloud_frames({folder_ / "kitti"}).error().message,
              HasSubstr("; its folder velodyne has some"));
}

TEST_F(CloudFile, a_folder_that_may_not_be_entered_is_an_error_that_says_so) {
  fs::permissions(folder_.path(), fs::perms::all);
  folder_.write("closed/a.ply", "ply");
  const fs::path closed = folder_ / "closed";
  for (const fs::perms perms : {fs::perms::none, fs::perms::owner_read | fs::perms::group_read}) {
    fs::permissions(closed, perms);
    const Unprivileged unprivileged;
    EXPECT_EQ(list_cloud_frames({closed}).error().message,
              closed.string() + ": cannot be read: Permission denied");
    EXPECT_EQ(read_manifest(closed).error().message,
              closed.string() + ": cannot be read: Permission denied");
  }
  fs::permissions(closed, fs::perms::owner_all);
}

TEST_F(CloudFile, errors_begin_with_the_path_and_take_one_line) {
  const fs::path missing = folder_ / "missing.ply";
  const auto expect_error = [](const fs::path& path, const std::string& part) {
    const auto loaded = read_cloud_file(path);
    ASSERT_FALSE(loaded);
    EXPECT_THAT(loaded.error().message, StartsWith(path.string() + ": "));
    EXPECT_THAT(loaded.error().message, HasSubstr(part));
    EXPECT_EQ(loaded.error().message.find('\n'), std::string::npos);
  };
  expect_error(missing, "no such file");
  expect_error(folder_.path(), "folder");
  expect_error("/dev/zero", "is not a regular file");  // it never ends
  expect_error(write("empty.ply", std::string()), "empty");
  expect_error(write("text.ply", std::string("hello, world")), "is not a PLY file");
  expect_error(write("text.data", std::string("hello, world")), "PLY, Draco");
  expect_error(write("cut.drc", std::string("DRACO\x02")), "truncated");
  expect_error(write("bad.ply", std::string("ply\nformat ascii 1.0\n")), "");
}

TEST_F(CloudFile, a_folder_gives_its_frames_in_natural_order) {
  for (const char* name : {"frame10.ply", "frame2.PLY", "frame1.ply", ".hidden.ply", "notes.txt",
                           "frame3.ply.bak", "ply"}) {
    write(name, kPly);
  }
  write("inner.ply/frame0.ply", kPly);  // a folder is not a frame, whatever its name
  const auto files = list_cloud_files({folder_.path()});
  ASSERT_TRUE(files) << files.error().message;
  EXPECT_THAT(names(*files), ElementsAre("frame1.ply", "frame2.PLY", "frame10.ply"));
}

TEST_F(CloudFile, a_pipe_in_a_folder_is_no_frame_and_it_is_said) {
  write("1.ply", kPly);
  ASSERT_EQ(::mkfifo((folder_ / "2.ply").c_str(), 0600), 0);
  const auto sequence = list_cloud_frames({folder_.path()});
  ASSERT_TRUE(sequence) << sequence.error().message;
  EXPECT_EQ(sequence->frames.size(), 1u);
  EXPECT_THAT(sequence->warnings, ElementsAre((folder_ / "2.ply").string() +
                                              ": is left out, because it is not a regular file"));
}

TEST_F(CloudFile, a_pipe_that_is_named_is_read_once_and_kept) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  ASSERT_EQ(::write(ends[1], kPly.data(), kPly.size()), std::ssize(kPly));
  ::close(ends[1]);
  const auto sequence = list_cloud_frames({fmt::format("/dev/fd/{}", ends[0])});
  ::close(ends[0]);
  ASSERT_TRUE(sequence) << sequence.error().message;
  ASSERT_EQ(sequence->frames.size(), 1u);
  EXPECT_EQ(up_of_frame(sequence->frames[0]), std::nullopt);
  for (int time = 0; time < 2; ++time) {
    const auto loaded = read_cloud_frame(sequence->frames[0]);
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_EQ(loaded->cloud.size(), 2u);
  }
}

TEST_F(CloudFile, of_several_formats_the_commonest_has_the_frames) {
  for (const char* name : {"0.ply", "1.ply", "2.PLY", "figure.glb", "0.drc", "1.drc"})
    write(name, kPly);
  std::vector<std::string> warnings;
  EXPECT_THAT(names(*list_cloud_files({folder_.path()}, &warnings)),
              ElementsAre("0.ply", "1.ply", "2.PLY"));
  EXPECT_THAT(warnings,
              testing::UnorderedElementsAre(HasSubstr("figure.glb"), HasSubstr("2 files")));
  write("2.drc", kPly);
  const auto files = list_cloud_files({folder_.path()});
  ASSERT_FALSE(files);
  EXPECT_THAT(files.error().message, HasSubstr("has as many files like"));
  EXPECT_EQ(names(*list_cloud_files({folder_ / "0.ply", folder_ / "0.drc"})).size(), 2u)
      << "files that are named are frames";
  write("walk.mcap", kPly);
  EXPECT_THAT(names(*list_cloud_files({folder_.path()})), ElementsAre("walk.mcap"));
}

TEST_F(CloudFile, files_that_may_be_something_else_count_where_there_are_no_others) {
  for (const char* name : {"2.txt", "1.csv", "calibration.bin"}) write(name, "1 2 3\n");
  EXPECT_THAT(names(*list_cloud_files({folder_.path()})), ElementsAre("1.csv", "2.txt"));
  write("sweep.pcd.bin", "1 2 3\n");
  EXPECT_THAT(names(*list_cloud_files({folder_.path()})), ElementsAre("sweep.pcd.bin"));
  for (const char* name : {"0.xyz", "1.xyz"}) write(name, "1 2 3\n");
  EXPECT_THAT(names(*list_cloud_files({folder_.path()})), ElementsAre("0.xyz", "1.xyz"));
}

TEST_F(CloudFile, the_format_tells_which_axis_points_up) {
  EXPECT_EQ(up_of_file(write("a.las", std::string("LASF"))), 'z');
  EXPECT_EQ(up_of_file(write("a.bin", std::string("1234"))), 'z');
  EXPECT_EQ(up_of_file(write("a.ply", kPly)), std::nullopt);
  EXPECT_EQ(up_of_file(folder_ / "missing.las"), std::nullopt);
}

TEST_F(CloudFile, points_that_were_not_measured_are_left_out_without_a_word) {
  const auto loaded = read_cloud_file(
      write("a.pcd", std::string("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\n"
                                 "HEIGHT 1\nDATA ascii\nnan nan nan\n1 2 3\n")));
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->cloud.size(), 1u);
  EXPECT_THAT(loaded->warnings, testing::IsEmpty());
}

TEST_F(CloudFile, explicitly_named_files_keep_their_order_and_may_have_any_name) {
  const fs::path b = write("b.ply", kPly), a = write("a.data", kPly);
  write("more/f2.ply", kPly);
  write("more/f1.ply", kPly);
  const auto files = list_cloud_files({b, a, folder_ / "more"});
  ASSERT_TRUE(files) << files.error().message;
  EXPECT_THAT(names(*files), ElementsAre("b.ply", "a.data", "f1.ply", "f2.ply"));
}

TEST_F(CloudFile, a_missing_input_or_a_folder_without_frames_is_an_error) {
  const auto missing = list_cloud_files({folder_ / "nowhere"});
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().message, HasSubstr("nowhere: no such file or folder"));
  write("notes.md", kPly);
  const auto none = list_cloud_files({folder_.path()});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, HasSubstr("has no point cloud files"));
  EXPECT_FALSE(list_cloud_files({}));
}

/// The folder of real captures, which may be missing.
fs::path real_data() {
  const char* named = std::getenv("POINTREEL_DATA");
  return named ? fs::path(named) : source_folder() / "../shared/data";
}

TEST(CloudFileOnRealData, every_mesh_of_the_liam_sequence_is_a_standing_person) {
  const fs::path folder = real_data() / "liam";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " does not exist";
  const auto files = list_cloud_files({folder});
  ASSERT_TRUE(files) << files.error().message;
  EXPECT_EQ(files->size(), 24u);
  for (const fs::path& file : *files) {
    const auto loaded = read_cloud_file(file);
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_NEAR(static_cast<double>(loaded->cloud.size()), 26582.0, 10.0);
    EXPECT_TRUE(loaded->cloud.has_normals());
    const Box box = bounds(loaded->cloud);
    EXPECT_NEAR(box.min.y, 0.0, 2.0) << "the feet are on the ground, in millimetres";
    EXPECT_NEAR(box.max.y, 1768.0, 5.0);
  }
}

}  // namespace
}  // namespace pointreel::cloud_file_test
