#include "codec/files/depth_video.h"

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/files/cloud_file.h"
#include "common/process/ffmpeg.h"
#include "common/process/run_program.h"
#include "tests/depth_scene.h"
#include "tests/temporary_folder.h"

namespace pointreel::depth_video_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr int kFrames = 20;

class DepthVideo : public testing::Test {
 protected:
  void SetUp() override {
    if (!is_installed("ffmpeg")) GTEST_SKIP() << "needs ffmpeg";
    depth_scene::write(pictures(), kFrames, camera_);
  }

  fs::path pictures() const { return folder_ / "pictures"; }
  fs::path video() const { return folder_ / "walk.mkv"; }

  /// ffmpeg, with the pictures as its inputs 0 (depth) and 1 (colours), ten a second.
  void make(const std::vector<std::string>& arguments) const {
    std::vector<std::string> all{"ffmpeg", "-hide_banner", "-loglevel", "error", "-y"};
    for (const char* kind : {"depth", "color"}) {
      const std::string files = (pictures() / kind / "%d.png").string();
      all.insert(all.end(), {"-framerate", "10", "-i", files});
    }
    all.insert(all.end(), arguments.begin(), arguments.end());
    all.push_back(video().string());
    const auto outcome = run_program(all);
    ASSERT_TRUE(outcome) << outcome.error().message;
    ASSERT_EQ(outcome->exit_code, 0) << outcome->out;
  }
  void make_lossless() const {
    make({"-map", "0", "-map", "1", "-c:v", "ffv1", "-pix_fmt:v:0", "gray16le", "-pix_fmt:v:1",
          "gbrp"});
  }
  void write_intrinsics(const std::string& name = "walk.json") const {
    folder_.write(name, depth_scene::intrinsics(camera_));
  }
  std::string error() const {
    const auto sequence = list_cloud_frames({video()});
    return sequence ? "it was read" : sequence.error().message;
  }
  /// Frames of the video are those of the pictures, point for point.
  void expect_pictures(const CloudSequence& sequence, const std::vector<int>& order) const {
    const auto expected = list_cloud_frames({pictures()});
    ASSERT_TRUE(expected) << expected.error().message;
    for (const int frame : order) {
      const auto i = static_cast<std::size_t>(frame);
      const auto a = read_cloud_frame(expected->frames[i]),
                 b = read_cloud_frame(sequence.frames[i]);
      ASSERT_TRUE(a) << a.error().message;
      ASSERT_TRUE(b) << b.error().message;
      EXPECT_EQ(a->cloud.positions, b->cloud.positions) << "frame " << frame;
      EXPECT_EQ(a->cloud.colors, b->cloud.colors) << "frame " << frame;
    }
  }

  const CameraIntrinsics camera_ = depth_scene::camera(64);
  const TemporaryFolder folder_;
};

TEST_F(DepthVideo, gives_the_pictures_that_were_put_into_it_in_any_order) {
  make_lossless();
  write_intrinsics();
  for (const std::uint64_t memory : {~std::uint64_t{0}, std::uint64_t{20'000}}) {
    const auto sequence = list_cloud_frames({video()}, {.max_memory = memory});
    ASSERT_TRUE(sequence) << sequence.error().message;
    ASSERT_EQ(sequence->frames.size(), std::size_t{kFrames});
    ASSERT_EQ(sequence->times_us.size(), std::size_t{kFrames});
    for (std::size_t i = 0; i < kFrames; ++i) EXPECT_EQ(sequence->times_us[i], 100'000 * i);
    EXPECT_EQ(sequence->fps, 10.0);
    EXPECT_EQ(up_of_frame(sequence->frames[0]), 'y');
    EXPECT_EQ(sequence->frames[7].name(), video().string() + ": picture 7");
    expect_pictures(*sequence, {0, 1, 2, 17, 3, 19, 18, 17, 16, 15, 14, 0, 9, 19});
  }
}

TEST_F(DepthVideo, tracks_may_be_in_any_order_and_begin_late_and_be_chosen_by_their_names) {
  // As Azure Kinect records it, with infrared that is grey of 16 bits, too. Most pictures need
  // earlier ones to be decoded, and those are others in each track.
  make({"-filter_complex",
        "[0:v]negate[ir]",
        "-map",
        "1",
        "-map",
        "[ir]",
        "-map",
        "0",
        "-c:v:0",
        "ffv1",
        "-pix_fmt:v:0",
        "gbrp",
        "-c:v:1",
        "ffv1",
        "-pix_fmt:v:1",
        "gray16be",
        "-c:v:2",
        "ffv1",
        "-g:v:2",
        "7",
        "-pix_fmt:v:2",
        "gray16be",
        "-metadata:s:v:0",
        "title=COLOR",
        "-metadata:s:v:1",
        "title=IR",
        "-metadata:s:v:2",
        "title=DEPTH",
        "-output_ts_offset",
        "3.7"});
  write_intrinsics("intrinsic.json");
  const auto sequence = list_cloud_frames({folder_.path()});
  ASSERT_TRUE(sequence) << sequence.error().message;
  ASSERT_EQ(sequence->frames.size(), std::size_t{kFrames});
  expect_pictures(*sequence, {12, 0, 5, 6, 19, 14, 7});
}

TEST_F(DepthVideo, without_colors_has_points_alone) {
  make({"-map", "0", "-c:v", "ffv1", "-pix_fmt", "gray16le"});
  write_intrinsics();
  const auto sequence = list_cloud_frames({video()});
  ASSERT_TRUE(sequence) << sequence.error().message;
  const auto loaded = read_cloud_frame(sequence->frames.at(3));
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_FALSE(loaded->cloud.has_colors());
  EXPECT_GT(loaded->cloud.size(), 64u * 48u * 9 / 10);
}

TEST_F(DepthVideo, colors_that_lose_a_little_are_those_of_the_same_picture) {
  make({"-map", "1", "-map", "0", "-c:v:0", "mjpeg", "-q:v:0", "2", "-pix_fmt:v:0", "yuvj444p",
        "-c:v:1", "ffv1", "-pix_fmt:v:1", "gray16le"});
  write_intrinsics();
  const auto sequence = list_cloud_frames({video()});
  ASSERT_TRUE(sequence) << sequence.error().message;
  const auto exact = list_cloud_frames({pictures()});
  for (const std::size_t frame : {std::size_t{0}, std::size_t{13}}) {
    const auto a = read_cloud_frame(exact->frames[frame]),
               b = read_cloud_frame(sequence->frames[frame]);
    ASSERT_TRUE(a && b);
    ASSERT_EQ(a->cloud.colors.size(), b->cloud.colors.size());
    double error = 0.0;
    for (std::size_t i = 0; i < a->cloud.colors.size(); ++i)
      error += glm::length(glm::vec3(a->cloud.colors[i]) - glm::vec3(b->cloud.colors[i])) / 257.0;
    EXPECT_LT(error / static_cast<double>(a->cloud.size()), 4.0);
  }
}

TEST_F(DepthVideo, what_is_no_video_of_depth_is_an_error_that_says_why) {
  folder_.write("walk.mkv", "hello, world");
  EXPECT_THAT(error(), AllOf(StartsWith(video().string() + ": is not a readable Matroska video"),
                             Not(HasSubstr("\n"))));
  folder_.write("walk.mkv", "");
  EXPECT_THAT(error(), HasSubstr("is not a readable Matroska video"));
  make({"-map", "1", "-c:v", "mjpeg", "-pix_fmt", "yuvj420p"});
  EXPECT_THAT(error(), HasSubstr("has no track of depth, which is grey of 16 bits (gray16le); it "
                                 "has mjpeg in yuvj420p"));
  make_lossless();
  EXPECT_THAT(error(), AllOf(StartsWith(video().string()), HasSubstr("walk.json: is missing")));
  write_intrinsics();
  EXPECT_EQ(error(), "it was read");
  // A playlist must not make ffmpeg read other files.
  folder_.write("walk.mkv",
                fmt::format("ffconcat version 1.0\nfile '{}'\n", (folder_ / "other.mkv").string()));
  EXPECT_THAT(error(), HasSubstr("is not a readable Matroska video"));
  const auto loaded = read_cloud_file(video());
  ASSERT_FALSE(loaded);
}

TEST_F(DepthVideo, a_damaged_picture_is_an_error_and_takes_no_place_of_another) {
  make({"-map", "0", "-c:v", "ffv1", "-slicecrc", "1", "-pix_fmt", "gray16le"});
  write_intrinsics();
  std::ifstream in(video(), std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), {});
  in.close();
  for (std::size_t at = bytes.size() / 2; at < bytes.size() / 2 + 100; ++at) bytes[at] ^= 0x5a;
  folder_.write("walk.mkv", bytes);
  const auto sequence = list_cloud_frames({video()});
  ASSERT_TRUE(sequence) << sequence.error().message;
  const auto expected = list_cloud_frames({pictures()});
  std::size_t failed = 0;
  for (std::size_t i = 0; i < sequence->frames.size(); ++i) {
    const auto loaded = read_cloud_frame(sequence->frames[i]);
    if (!loaded) {
      ++failed;
      EXPECT_THAT(loaded.error().message, AllOf(HasSubstr("depth: "), Not(HasSubstr("\n"))));
      continue;
    }
    const auto time = static_cast<std::size_t>(sequence->times_us[i] + 50'000) / 100'000;
    EXPECT_EQ(loaded->cloud.positions, read_cloud_frame(expected->frames[time])->cloud.positions);
  }
  EXPECT_GT(failed + kFrames - sequence->frames.size(), 0u);

  // What ends early has the pictures that are there.
  folder_.write("walk.mkv", bytes.substr(0, bytes.size() / 3));
  const auto cut = list_cloud_frames({video()});
  ASSERT_TRUE(cut) << cut.error().message;
  EXPECT_TRUE(read_cloud_frame(cut->frames[0]));
  EXPECT_THAT(cut->warnings, testing::ElementsAre(fmt::format(
                                 "{}: ends early, after {} frames: what comes before is read",
                                 video().string(), cut->frames.size())));
}

}  // namespace
}  // namespace pointreel::depth_video_test
