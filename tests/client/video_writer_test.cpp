#include "client/record/video_writer.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/record/open_recorder.h"
#include "tests/read_file.h"
#include "tests/temporary_folder.h"

namespace pointreel::video_writer_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return text;
  std::array<char, 4096> part;
  for (std::size_t size; (size = fread(part.data(), 1, part.size(), pipe)) > 0;)
    text.append(part.data(), size);
  pclose(pipe);
  return text;
}

/// A picture whose colour encodes its number.
Image numbered(glm::ivec2 size, int number) {
  const auto gray = static_cast<std::uint8_t>(10 + 7 * (number % 32));
  Image image{size.x, size.y, {}};
  image.pixels.assign(static_cast<std::size_t>(size.x * size.y), glm::u8vec3(gray));
  return image;
}

/// The properties that ffprobe and ffmpeg report of a file.
struct Video {
  explicit Video(const fs::path& file) {
    const auto json = nlohmann::json::parse(
        output_of("ffprobe -v quiet -select_streams v -show_streams -show_frames -of json '" +
                  file.string() + "'"),
        nullptr, false);
    if (json.is_discarded() || json["streams"].size() != 1) return;
    stream = json["streams"][0];
    for (const auto& frame : json["frames"])
      times.push_back(std::stod(frame["pts_time"].get<std::string>()));
    const std::string raw = output_of("ffmpeg -v quiet -i '" + file.string() +
                                      "' -fps_mode passthrough -f rawvideo -pix_fmt rgb24 -");
    const std::size_t bytes =
        3 * stream["width"].get<std::size_t>() * stream["height"].get<std::size_t>();
    for (std::size_t at = 0; at + bytes <= raw.size(); at += bytes)
      colors.push_back({static_cast<std::uint8_t>(raw[at + bytes / 2 / 3 * 3]),
                        static_cast<std::uint8_t>(raw[at + bytes / 2 / 3 * 3 + 1]),
                        static_cast<std::uint8_t>(raw[at + bytes / 2 / 3 * 3 + 2])});
  }

  nlohmann::json stream;
  std::vector<double> times;
  std::vector<glm::ivec3> colors;  ///< of a pixel in the middle of each frame
};

class VideoWriterTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!find_ffmpeg()) GTEST_SKIP() << "ffmpeg is not installed";
  }

  /// Writes one picture for each time.
  fs::path write(const std::string& name, glm::ivec2 size,
                 const std::vector<std::uint64_t>& times_us,
                 const std::optional<FrameRate>& rate) const {
    const fs::path file = folder_ / name;
    auto writer = VideoWriter::create(file.string(), size, rate);
    if (!writer) {
      ADD_FAILURE() << writer.error().message;
      return file;
    }
    for (std::size_t i = 0; i < times_us.size(); ++i) {
      const auto added = (*writer)->add(numbered(size, static_cast<int>(i)), times_us[i]);
      EXPECT_TRUE(added) << added.error().message;
    }
    EXPECT_FALSE(fs::exists(file));
    const auto finished = (*writer)->finish(1'000'000);
    EXPECT_TRUE(finished) << finished.error().message;
    EXPECT_FALSE(fs::exists(file.string() + ".part"));
    return file;
  }

  static void expect_each_once(const Video& video, std::size_t count) {
    ASSERT_EQ(video.colors.size(), count);
    for (std::size_t i = 0; i < count; ++i)
      EXPECT_NEAR(video.colors[i].g, numbered({1, 1}, static_cast<int>(i)).pixels[0].g, 3) << i;
  }

  const TemporaryFolder folder_;
};

TEST_F(VideoWriterTest, writes_each_picture_once_at_exactly_the_given_rate) {
  std::vector<std::uint64_t> times;
  for (std::uint64_t i = 0; i < 24; ++i) times.push_back((i * 1'001'000'000 + 15'000) / 30'000);
  for (const char* name : {"a.mp4", "a.mkv", "a.webm"}) {
    SCOPED_TRACE(name);
    const Video video(write(name, {64, 48}, times, FrameRate{30'000, 1001}));
    EXPECT_EQ(video.stream["r_frame_rate"], "30000/1001");
    EXPECT_EQ(video.stream["avg_frame_rate"], "30000/1001");
    EXPECT_EQ(video.stream["pix_fmt"], "yuv420p");
    EXPECT_EQ(video.stream["color_space"], "bt709");
    EXPECT_EQ(video.stream["codec_name"], name == std::string("a.webm") ? "vp9" : "h264");
    expect_each_once(video, times.size());
    const double resolution = name == std::string("a.mp4") ? 1e-6 : 1e-3;
    ASSERT_EQ(video.times.size(), times.size());
    for (std::size_t i = 0; i < times.size(); ++i)
      EXPECT_NEAR(video.times[i], static_cast<double>(i) * 1001.0 / 30'000.0, 0.51 * resolution);
  }
}

TEST_F(VideoWriterTest, keeps_the_times_after_a_picture_that_stays_for_an_hour) {
  const std::vector<std::uint64_t> times = {0, 40'000, 3'600'040'000, 3'600'080'000};
  for (const char* name : {"c.mp4", "c.mkv", "c.webm"}) {
    SCOPED_TRACE(name);
    const Video video(write(name, {64, 48}, times, std::nullopt));
    ASSERT_EQ(video.times.size(), times.size());
    for (std::size_t i = 0; i < times.size(); ++i)
      EXPECT_NEAR(video.times[i], static_cast<double>(times[i]) / 1e6, 1e-3) << i;
  }
}

TEST_F(VideoWriterTest, writes_unevenly_spaced_pictures_at_exactly_their_times) {
  const std::vector<std::uint64_t> times = {0, 10'007, 50'000, 52'001, 1'234'567, 2'000'003};
  for (const char* name : {"b.mp4", "b.mkv", "b.webm"}) {
    SCOPED_TRACE(name);
    const Video video(write(name, {64, 48}, times, std::nullopt));
    expect_each_once(video, times.size());
    const double resolution = name == std::string("b.mp4") ? 1e-5 : 1e-3;
    ASSERT_EQ(video.times.size(), times.size());
    for (std::size_t i = 0; i < times.size(); ++i)
      EXPECT_NEAR(video.times[i], static_cast<double>(times[i]) / 1e6, 0.51 * resolution) << i;
    // The video does not end before its last picture.
    if (video.stream.contains("duration")) {
      EXPECT_GT(std::stod(video.stream["duration"].get<std::string>()), 2.0);
    }
  }
}

TEST_F(VideoWriterTest, preserves_colours) {
  const fs::path file = folder_ / "c.mp4";
  auto writer = VideoWriter::create(file.string(), {32, 32}, FrameRate{10, 1});
  ASSERT_TRUE(writer);
  const std::vector<glm::u8vec3> colors = {{200, 40, 40}, {30, 180, 60}, {20, 40, 220}};
  for (std::size_t i = 0; i < colors.size(); ++i) {
    Image image = numbered({32, 32}, 0);
    image.pixels.assign(image.pixels.size(), colors[i]);
    ASSERT_TRUE((*writer)->add(image, 100'000 * i));
  }
  ASSERT_TRUE((*writer)->finish(1'000'000));
  const Video video(file);
  ASSERT_EQ(video.colors.size(), colors.size());
  for (std::size_t i = 0; i < colors.size(); ++i)
    for (int channel = 0; channel < 3; ++channel)
      EXPECT_NEAR(video.colors[i][channel], colors[i][channel], 4) << i << " " << channel;
}

TEST_F(VideoWriterTest, drops_the_last_row_and_column_of_odd_sizes) {
  const Video video(write("d.mp4", {65, 49}, {0, 100'000}, FrameRate{10, 1}));
  EXPECT_EQ(video.stream["width"], 64);
  EXPECT_EQ(video.stream["height"], 48);
  expect_each_once(video, 2);
  EXPECT_FALSE(VideoWriter::create((folder_ / "e.mp4").string(), {1, 10}, std::nullopt));
}

TEST_F(VideoWriterTest, writes_a_video_of_a_single_picture) {
  const Video video(write("f.mp4", {64, 48}, {0}, FrameRate{30, 1}));
  expect_each_once(video, 1);
}

TEST_F(VideoWriterTest, writes_pictures_with_equal_times_one_after_the_other) {
  const Video video(write("g.mp4", {64, 48}, {0, 40'000, 40'000, 80'000}, std::nullopt));
  ASSERT_EQ(video.times.size(), 5u) << "the last one is shown to the end";
  for (std::size_t i = 1; i < video.times.size(); ++i)
    EXPECT_GT(video.times[i], video.times[i - 1]);
}

TEST_F(VideoWriterTest, shows_the_last_picture_to_its_end) {
  for (const char* name : {"h.mp4", "h.mkv", "h.webm"}) {
    int number = 0;
    for (const std::vector<std::uint64_t>& times :
         {std::vector<std::uint64_t>{0}, {0, 100'000, 210'000, 300'000}, {0, 100'000, 900'000}}) {
      SCOPED_TRACE(fmt::format("{} {}", name, number));
      const fs::path file =
          write(fmt::format("{}{}", number++, name), {64, 48}, times, std::nullopt);
      const double seconds =
          std::stod("0" + output_of("ffprobe -v quiet -show_entries format=duration -of csv=p=0 '" +
                                    file.string() + "'"));
      EXPECT_NEAR(seconds, 1.0, 0.06);
      EXPECT_EQ(Video(file).times.size(), times.size() + 1);
    }
  }
}

/// A sound that is like itself at no other time.
float sound_at(std::uint64_t n) {
  const double seconds = static_cast<double>(n) / kAudioRate;
  return static_cast<float>(
      0.3 * std::sin(2.0 * std::numbers::pi * (300.0 + 400.0 * seconds) * seconds) +
      0.2 * std::sin(2.0 * std::numbers::pi * 1234.5 * seconds));
}

/// How far the samples are from the sound, if they begin with its sample number `first`, as a share
/// of its power.
double error_of(const std::vector<float>& samples, std::int64_t first) {
  double error = 0.0, power = 0.0;
  for (std::size_t i = 4'800; i + 4'800 < samples.size(); ++i) {
    const double right = sound_at(static_cast<std::uint64_t>(static_cast<std::int64_t>(i) + first));
    error += std::pow(samples[i] - right, 2.0);
    power += right * right;
  }
  return error / power;
}

TEST_F(VideoWriterTest, has_sound_from_its_first_picture_to_the_end_of_its_last) {
  for (const char* name : {"s.mkv", "s.webm", "s.mp4"}) {
    const fs::path file = folder_ / name;
    RecordedSound sound;
    sound.read = [](std::uint64_t first, std::span<StereoSample> samples) -> Result<void> {
      for (std::size_t i = 0; i < samples.size(); ++i)
        samples[i] = {sound_at(first + i), sound_at(first + i)};
      return {};
    };
    sound.end_us = 2'000'000;
    auto writer = VideoWriter::create(file.string(), {320, 240}, FrameRate{25, 1}, sound);
    ASSERT_TRUE(writer) << writer.error().message;
    for (int i = 0; i < 50; ++i)
      ASSERT_TRUE((*writer)->add(numbered({320, 240}, i), static_cast<std::uint64_t>(40'000 * i)));
    const auto finished = (*writer)->finish(2'000'000);
    ASSERT_TRUE(finished) << finished.error().message;
    EXPECT_EQ(Video(file).times.size(), 50u);
    const std::string raw = output_of("ffmpeg -v quiet -i '" + file.string() +
                                      "' -f f32le -ar 48000 -af 'pan=mono|c0=c0' -");
    std::vector<float> samples(raw.size() / sizeof(float));
    std::memcpy(samples.data(), raw.data(), samples.size() * sizeof(float));
    EXPECT_GE(samples.size(), 2u * kAudioRate) << name;
    // AAC has frames of 1024 samples.
    EXPECT_LE(samples.size(), 2u * kAudioRate + (std::string(name) == "s.mp4" ? 1'023u : 0u))
        << name;
    EXPECT_LT(error_of(samples, 0), 0.02) << name;
    for (const int off : {-1, 1})
      EXPECT_LT(error_of(samples, 0), error_of(samples, off)) << name << ": to the sample";
  }
}

TEST_F(VideoWriterTest, says_why_there_is_no_sound) {
  const fs::path file = folder_ / "t.mkv";
  RecordedSound sound;
  sound.read = [](std::uint64_t, std::span<StereoSample>) -> Result<void> {
    return fail("is damaged");
  };
  auto writer = VideoWriter::create(file.string(), {64, 48}, FrameRate{25, 1}, sound);
  ASSERT_TRUE(writer);
  ASSERT_TRUE((*writer)->add(numbered({64, 48}, 0), 0));
  const auto finished = (*writer)->finish(40'000);
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().message, file.string() + ": was not recorded: sound: is damaged");
  writer->reset();
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST_F(VideoWriterTest, leaves_no_file_if_it_is_not_finished) {
  const fs::path file = folder_ / "h.mp4";
  {
    auto writer = VideoWriter::create(file.string(), {64, 48}, std::nullopt);
    ASSERT_TRUE(writer);
    ASSERT_TRUE((*writer)->add(numbered({64, 48}, 0), 0));
  }
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST_F(VideoWriterTest, reports_why_a_place_cannot_be_written) {
  const std::string file = (folder_ / "no/such/i.mp4").string();
  auto writer = VideoWriter::create(file, {64, 48}, FrameRate{30, 1});
  Result<void> ended = writer ? Result<void>() : tl::unexpected(writer.error());
  for (int i = 0; i < 1000 && ended; ++i) ended = (*writer)->add(numbered({64, 48}, i), 0);
  if (ended) ended = (*writer)->finish(1'000'000);
  ASSERT_FALSE(ended);
  EXPECT_THAT(ended.error().message, StartsWith(file + ": was not recorded: ffmpeg ended: "));
  EXPECT_THAT(ended.error().message, HasSubstr("No such file or directory"));
}

/// Makes a script that runs these commands in place of ffmpeg.
std::string script(const TemporaryFolder& folder, const std::string& commands) {
  const fs::path file = folder.write("ffmpeg", "#!/bin/sh\n" + commands + "\n");
  fs::permissions(file, fs::perms::owner_all);
  return file.string();
}

TEST(VideoWriter, quotes_the_output_of_an_encoder_that_exits_early) {
  const TemporaryFolder folder;
  const std::string program =
      script(folder, "head -c 100000 > /dev/null; echo '[x @ 0x5] no space left' >&2; exit 1");
  auto writer =
      VideoWriter::create((folder / "a.mp4").string(), {64, 48}, std::nullopt, {}, program);
  ASSERT_TRUE(writer);
  Result<void> added;
  for (int i = 0; i < 1000 && added; ++i) added = (*writer)->add(numbered({64, 48}, i), 0);
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().message,
            (folder / "a.mp4").string() + ": was not recorded: ffmpeg ended: no space left");
}

// ffmpeg 5.1 ends well when it cannot write any more.
TEST_F(VideoWriterTest, a_full_disk_leaves_the_video_from_before_and_nothing_else) {
  const TemporaryFolder programs;
  const std::string program = script(programs, "trap '' XFSZ; ulimit -f 64; exec ffmpeg \"$@\"");
  Image noise = numbered({320, 240}, 0);
  std::uint32_t state = 1;
  for (glm::u8vec3& pixel : noise.pixels) {
    state = state * 1'664'525u + 1'013'904'223u;
    pixel = glm::u8vec3(state >> 24, state >> 16, state >> 8);
  }
  for (const char* name : {"j.mp4", "j.mkv", "j.webm"}) {
    SCOPED_TRACE(name);
    const TemporaryFolder folder;
    const fs::path file = folder.write(name, "good");
    auto writer = VideoWriter::create(file.string(), {320, 240}, FrameRate{25, 1}, {}, program);
    Result<void> done = writer ? Result<void>() : tl::unexpected(writer.error());
    for (std::uint64_t i = 0; i < 10 && done; ++i) done = (*writer)->add(noise, 40'000 * i);
    if (done) done = (*writer)->finish(400'000);
    ASSERT_FALSE(done);
    EXPECT_THAT(done.error().message, StartsWith(file.string() + ": was not recorded: "));
    writer->reset();
    EXPECT_EQ(read_file(file), "good");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
  }
}

TEST(VideoWriter, reports_an_encoder_that_ends_well_but_writes_nothing) {
  const TemporaryFolder folder;
  const std::string file = (folder / "a.mkv").string();
  auto writer = VideoWriter::create(file, {64, 48}, std::nullopt, {},
                                    script(folder, "cat > /dev/null; exit 0"));
  ASSERT_TRUE(writer);
  EXPECT_TRUE((*writer)->add(numbered({64, 48}, 0), 0));
  const auto finished = (*writer)->finish(1'000'000);
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().message, file + ": was not recorded: No such file or directory");
}

TEST(VideoWriter, reports_that_the_encoder_was_killed) {
  const TemporaryFolder folder;
  auto writer = VideoWriter::create((folder / "a.mp4").string(), {64, 48}, std::nullopt, {},
                                    script(folder, "kill -KILL $$"));
  Result<void> ended = writer ? Result<void>() : tl::unexpected(writer.error());
  for (int i = 0; i < 1000 && ended; ++i) ended = (*writer)->add(numbered({64, 48}, i), 0);
  ASSERT_FALSE(ended);
  EXPECT_THAT(ended.error().message, HasSubstr("ffmpeg ended: Killed"));
}

TEST(VideoWriter, reports_an_encoder_that_fails_at_the_end) {
  const TemporaryFolder folder;
  const std::string program = script(folder, "cat > /dev/null; echo 'no' >&2; exit 3");
  auto writer =
      VideoWriter::create((folder / "a.mp4").string(), {64, 48}, std::nullopt, {}, program);
  ASSERT_TRUE(writer);
  EXPECT_TRUE((*writer)->add(numbered({64, 48}, 0), 0));
  const auto finished = (*writer)->finish(1'000'000);
  ASSERT_FALSE(finished);
  EXPECT_THAT(finished.error().message, HasSubstr("ffmpeg ended: no"));
}

TEST(VideoWriter, explains_in_one_line_how_to_install_a_missing_encoder) {
  const TemporaryFolder folder;
  for (const std::string& program : {(folder / "none").string(), std::string("no-such-ffmpeg")}) {
    const auto found = find_ffmpeg(program);
    ASSERT_FALSE(found);
    EXPECT_THAT(found.error().message, HasSubstr("is not installed"));
    EXPECT_THAT(found.error().message, HasSubstr("out-%04d.png"));
    const auto writer =
        VideoWriter::create((folder / "a.mp4").string(), {8, 8}, std::nullopt, {}, program);
    ASSERT_FALSE(writer);
    EXPECT_EQ(writer.error().message, found.error().message);
  }
  EXPECT_TRUE(find_ffmpeg("sh"));
  EXPECT_TRUE(find_ffmpeg(script(folder, "exit 0")));
}

TEST(OpenRecorder, numbers_pictures_from_zero) {
  const TemporaryFolder folder;
  const std::string pattern = (folder / "out-%02d.png").string();
  ASSERT_TRUE(check_recording(pattern));
  const auto recorder = open_recorder(pattern, {4, 4}, std::nullopt);
  ASSERT_TRUE(recorder);
  ASSERT_TRUE((*recorder)->add(numbered({4, 4}, 0), 0));
  ASSERT_TRUE((*recorder)->add(numbered({4, 4}, 1), 5));
  ASSERT_TRUE((*recorder)->finish(1'000'000));
  EXPECT_TRUE(fs::exists(folder / "out-00.png"));
  EXPECT_TRUE(fs::exists(folder / "out-01.png"));
  EXPECT_THAT(read_file(folder / "out-01.png"), HasSubstr("PNG"));
}

TEST(OpenRecorder, refuses_names_that_are_neither_videos_nor_numbered_pictures) {
  for (const char* path : {"", "out", "out.png", "out.avi", "out-%d-%d.png", "mp4"}) {
    const auto checked = check_recording(path);
    ASSERT_FALSE(checked) << path;
    EXPECT_THAT(checked.error().message, HasSubstr(".webm"));
    EXPECT_FALSE(open_recorder(path, {4, 4}, std::nullopt));
  }
}

}  // namespace
}  // namespace pointreel::video_writer_test
