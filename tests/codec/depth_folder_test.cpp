#include "codec/files/depth_folder.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "codec/files/cloud_file.h"
#include "codec/files/cloud_folder.h"
#include "tests/depth_scene.h"
#include "tests/temporary_folder.h"

namespace pointreel::depth_folder_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

class DepthFolder : public testing::Test {
 protected:
  void write_depth(const std::string& name, int frame = 0) const {
    folder_.write("depth/" + name, depth_scene::png(depth_scene::depth(camera_, frame)));
  }
  void write_color(const std::string& name, std::uint8_t blue) const {
    ColorPicture color = depth_scene::color(camera_, 0);
    for (std::size_t i = 2; i < color.rgb.size(); i += 3) color.rgb[i] = blue;
    folder_.write(name, depth_scene::png(color));
  }
  void write_intrinsics(const std::string& name = "intrinsic.json") const {
    folder_.write(name, depth_scene::intrinsics(camera_));
  }
  /// The blue of each frame, as write_color has set it.
  std::vector<int> blues() const {
    std::vector<int> blues;
    const auto sequence = list_cloud_frames({folder_.path()});
    EXPECT_TRUE(sequence) << sequence.error().message;
    if (!sequence) return blues;
    for (const CloudFrame& frame : sequence->frames) {
      const auto loaded = read_cloud_frame(frame);
      EXPECT_TRUE(loaded) << loaded.error().message;
      if (loaded && loaded->cloud.has_colors()) blues.push_back(loaded->cloud.colors[0].z / 257);
    }
    return blues;
  }
  std::string error() const {
    const auto sequence = list_cloud_frames({folder_.path()});
    return sequence ? "it was read" : sequence.error().message;
  }

  const CameraIntrinsics camera_ = depth_scene::camera(80);
  const TemporaryFolder folder_;
};

TEST_F(DepthFolder, is_a_sequence_in_which_y_points_up) {
  depth_scene::write(folder_.path(), 12, camera_);
  // As in the TUM's data sets. Text files may hold points, too, but not in such a folder.
  folder_.write("depth.txt", "1 2 3\n");
  const auto sequence = list_cloud_frames({folder_.path()});
  ASSERT_TRUE(sequence) << sequence.error().message;
  ASSERT_EQ(sequence->frames.size(), 12u);
  EXPECT_TRUE(sequence->times_us.empty());
  EXPECT_TRUE(has_cloud_files(folder_.path()));
  EXPECT_EQ(up_of_frame(sequence->frames[0]), 'y');
  EXPECT_EQ(sequence->frames[10].name(), folder_.path().string() + ": depth/10.png");
  // The ball moves to the right.
  const auto first = read_cloud_frame(sequence->frames[1]),
             last = read_cloud_frame(sequence->frames[10]);
  ASSERT_TRUE(first && last);
  const auto redness = [](const PointCloud& cloud) {
    double sum = 0.0, count = 0.0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (cloud.colors[i].x < 50'000) continue;
      sum += cloud.positions[i].x;
      count += 1.0;
    }
    return sum / count;
  };
  // What is seen of it moves a little less than its centre does. Its outline is left out as flying.
  const auto seen = [&](int frame) {
    double sum = 0.0, count = 0.0;
    for (std::uint32_t v = 0; v < camera_.height; ++v) {
      for (std::uint32_t u = 0; u < camera_.width; ++u) {
        const auto pixel = depth_scene::look(camera_, u, v, frame);
        if (!pixel.ball) continue;
        sum += (u - camera_.cx) / camera_.fx * pixel.depth;
        count += 1.0;
      }
    }
    return sum / count;
  };
  EXPECT_NEAR(redness(last->cloud) - redness(first->cloud), seen(10) - seen(1), 0.05);

  const auto fetched = fetch_cloud_frame(sequence->frames[1], 1 << 20);
  ASSERT_TRUE(fetched) << fetched.error().message;
  EXPECT_EQ(read_cloud(fetched->bytes, fetched->format).value().cloud.positions,
            first->cloud.positions);
}

TEST_F(DepthFolder, folders_may_be_named_in_letters_of_any_case) {
  depth_scene::write(folder_.path(), 2, camera_);
  fs::rename(folder_ / "depth", folder_ / "Depth");
  fs::rename(folder_ / "color", folder_ / "COLOR");
  EXPECT_EQ(blues().size(), 2u);
}

TEST_F(DepthFolder, files_of_points_come_first_unless_the_pictures_are_named) {
  depth_scene::write(folder_.path(), 3, camera_);
  const fs::path ply = folder_.write("a.ply", "ply\n");
  const auto sequence = list_cloud_frames({folder_.path()});
  ASSERT_TRUE(sequence) << sequence.error().message;
  ASSERT_EQ(sequence->frames.size(), 1u);
  EXPECT_EQ(sequence->frames[0].file, ply);
  EXPECT_THAT(sequence->warnings, ElementsAre(HasSubstr("its depth pictures are left out")));
  for (const char* const pictures : {"depth", "depth/", "./depth/."}) {
    EXPECT_TRUE(has_cloud_files(folder_ / pictures));
    const auto named = list_cloud_frames({folder_ / pictures});
    ASSERT_TRUE(named) << named.error().message;
    EXPECT_EQ(named->frames.size(), 3u);
  }
}

TEST_F(DepthFolder, a_scale_that_is_not_given_is_said) {
  depth_scene::write(folder_.path(), 1, camera_);
  folder_.write("intrinsic.json", R"({"fx": 60, "fy": 60, "cx": 40, "cy": 30})");
  EXPECT_THAT(list_cloud_frames({folder_.path()})->guesses,
              ElementsAre(HasSubstr("depth of 1000 steps per metre")));
  folder_.write("intrinsic.json",
                R"({"fx": 60, "fy": 60, "cx": 40, "cy": 30, "depth_scale": 5000})");
  EXPECT_THAT(list_cloud_frames({folder_.path()})->guesses, testing::IsEmpty());
}

TEST_F(DepthFolder, times_in_names_tell_when_and_which_colors_belong_to_depth) {
  write_intrinsics();
  write_depth("1305031102.160407.png");
  write_depth("1305031102.194330.png");
  write_depth("1305031102.26.png");
  write_color("rgb/1305031102.175304.png", 10);
  write_color("rgb/1305031102.211214.png", 20);
  write_color("rgb/1305031102.243211.png", 30);
  write_color("rgb/1305031102.275326.png", 40);
  const auto sequence = list_cloud_frames({folder_.path()});
  ASSERT_TRUE(sequence) << sequence.error().message;
  EXPECT_THAT(sequence->times_us, ElementsAre(0, 33'923, 99'593));
  EXPECT_EQ(sequence->frames[0].time_us, 1'305'031'102'160'407u);
  EXPECT_THAT(blues(), ElementsAre(10, 20, 40));
}

TEST_F(DepthFolder, whole_numbers_are_times_if_they_have_as_many_digits) {
  write_intrinsics();
  write_depth("1403636579763555584.png");
  write_depth("1403636579813555456.png");
  EXPECT_THAT(list_cloud_frames({folder_.path()})->times_us, ElementsAre(0, 50'000));
}

TEST_F(DepthFolder, without_times_names_or_else_places_tell_which_colors_belong_to_depth) {
  write_intrinsics("camera_intrinsic.json");
  write_depth("000009.png");
  write_depth("000010.png");
  write_color("color/000010.png", 10);
  write_color("color/000009.png", 9);
  write_color("color/000008.png", 8);
  EXPECT_THAT(blues(), ElementsAre(9, 10));
}

TEST_F(DepthFolder, few_frames_without_colors_of_their_own_are_a_warning) {
  write_intrinsics();
  for (const char* const name : {"0.png", "1.png", "2.png", "5.png"}) write_depth(name);
  write_color("color/0.png", 10);
  write_color("color/2.png", 30);
  write_color("color/5.png", 60);
  write_color("color/6.png", 70);
  EXPECT_THAT(blues(), ElementsAre(10, 10, 30, 60));
  EXPECT_THAT(
      list_cloud_frames({folder_.path()})->warnings,
      ElementsAre(HasSubstr(": 1 of 4 depth pictures have no colour picture of the same name"),
                  HasSubstr("2 frames are missing: 3 to 4")));
}

TEST_F(DepthFolder, pictures_in_other_folders_are_a_warning) {
  write_intrinsics();
  write_depth("0.png");
  write_color("left/0.png", 10);
  EXPECT_THAT(list_cloud_frames({folder_.path()})->warnings,
              ElementsAre(HasSubstr(": the pictures in left are not read")));
}

TEST_F(DepthFolder, as_many_colors_as_depth_are_taken_in_their_order) {
  write_intrinsics();
  write_depth("d9.png");
  write_depth("d10.png");
  write_color("image/c1.png", 1);
  write_color("image/c2.png", 2);
  EXPECT_THAT(blues(), ElementsAre(1, 2));
  write_color("image/c3.png", 3);
  EXPECT_THAT(error(), HasSubstr("image: has 3 pictures for 2 of depth, and neither names nor"));
}

TEST_F(DepthFolder, faults_of_a_folder_are_errors_that_say_where) {
  write_depth("0.png");
  EXPECT_THAT(error(), AllOf(StartsWith((folder_ / "intrinsic.json").string() + ": is missing"),
                             HasSubstr("depth_scale, the steps per metre")));
  folder_.write("intrinsic.json", R"({"fx": 0})");
  EXPECT_THAT(error(), HasSubstr("intrinsic.json: fy: is missing"));
  folder_.write("intrinsic.json", std::string(2u << 20, ' '));
  EXPECT_THAT(error(), HasSubstr("intrinsic.json: has 2097152 bytes"));
  write_intrinsics();
  folder_.write("depth/0.png", "\x89PNG\r\n\x1a\nrubbish");
  const auto sequence = list_cloud_frames({folder_.path()});
  ASSERT_TRUE(sequence) << sequence.error().message;
  const auto loaded = read_cloud_frame(sequence->frames[0]);
  ASSERT_FALSE(loaded);
  EXPECT_THAT(
      loaded.error().message,
      StartsWith(folder_.path().string() + ": depth/0.png: depth: is not a readable PNG file"));
  fs::remove(folder_ / "depth/0.png");
  EXPECT_THAT(error(), HasSubstr("has no point cloud files"));
  EXPECT_FALSE(has_cloud_files(folder_.path()));
}

TEST_F(DepthFolder, intrinsics_that_are_a_pipe_are_not_waited_for) {
  write_depth("0.png");
  const fs::path pipe = folder_.path() / "intrinsic.json";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(error(), pipe.string() + ": is not a regular file");
}

TEST_F(DepthFolder, clocks_that_differ_are_noticed) {
  write_intrinsics();
  write_depth("1305031102.16.png");
  write_color("rgb/1305031105.16.png", 1);
  EXPECT_THAT(error(), HasSubstr("rgb: has no picture within a second of any depth picture"));
  write_depth("1305031105.00.png");
  EXPECT_THAT(
      list_cloud_frames({folder_.path()})->warnings,
      ElementsAre(HasSubstr("1 of 2 depth pictures have no colour picture within a second")));
  EXPECT_THAT(blues(), ElementsAre(1));
}

TEST_F(DepthFolder, a_picture_of_colors_without_a_byte_is_an_error) {
  depth_scene::write(folder_.path(), 1, camera_);
  for (const auto& entry : fs::directory_iterator(folder_ / "color"))
    fs::resize_file(entry.path(), 0);
  const auto loaded = read_cloud_frame(list_cloud_frames({folder_.path()})->frames[0]);
  ASSERT_FALSE(loaded);
  EXPECT_THAT(loaded.error().message, HasSubstr("color/0.png: is empty"));
}

TEST_F(DepthFolder, one_picture_is_no_cloud) {
  write_depth("0.png");
  const auto loaded = read_cloud_file(folder_ / "depth/0.png");
  ASSERT_FALSE(loaded);
  EXPECT_THAT(loaded.error().message, HasSubstr("name the folder that has depth/*.png"));
  const auto e57 = read_cloud_file(folder_.write("a.e57", "ASTM-E57 and more than that"));
  ASSERT_FALSE(e57);
  EXPECT_THAT(e57.error().message, HasSubstr("is an E57 file, which is not read"));
}

}  // namespace
}  // namespace pointreel::depth_folder_test
