// Packing in parts: the same package, whatever happens to the parts.

#include <cmath>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/files/recording_writer.h"
#include "server/commands/pack_arguments.h"
#include "server/parts/join_parts.h"
#include "server/parts/pack_part.h"
#include "server/parts/plan.h"
#include "tests/depth_scene.h"
#include "tests/packed_reel.h"
#include "tests/tone.h"

namespace pointreel::parts_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr int kFrames = 20;  // 7 segments, the last of 2 frames

class Parts : public PackTest {
 protected:
  void SetUp() override { write_frames(kFrames); }

  /// The options that a command line stands for.
  PackOptions options(const std::vector<std::string>& arguments = {}) const {
    Result<PackOptions> options = parse_pack_command_line(arguments);
    EXPECT_TRUE(options) << options.error().message;
    options->inputs = {frames_};
    options->output = reel_;
    options->segment_frames = 3;
    options->threads = 2;
    return *options;
  }

  /// The package as one process makes it.
  std::map<std::string, std::string> whole(PackOptions one) {
    one.output = reel_.parent_path() / "whole";
    one.name = "ball";
    EXPECT_TRUE(pack(one));
    return contents(one.output);
  }

  void make(const PackOptions& options, const std::vector<std::string>& arguments = {}) {
    const Result<MadePlan> made = make_plan(options, arguments);
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(made->frames, kFrames);
    EXPECT_EQ(made->segments, 7u);
  }

  Result<PartReport> part(std::uint32_t index, std::uint32_t count, bool fail_fast = false,
                          const PackListener& listener = {}) {
    const Result<PackPlan> plan = read_plan(reel_);
    EXPECT_TRUE(plan) << plan.error().message;
    return pack_part(*plan, options(plan->arguments), {index, count}, fail_fast, listener);
  }

  /// A folder of recordings, at times that are not even, so that one that was lost would show.
  fs::path write_recordings(bool normals) {
    const fs::path recordings = reel_.parent_path() / "recordings";
    fs::create_directory(recordings);
    std::uint64_t time_us = 1'700'000'000'000'000;
    for (const auto& [name, frames] : {std::pair{"1.mcap", 13}, std::pair{"2.mcap", 7}}) {
      RecordingWriter writer(recordings / name);
      for (int i = 0; i < frames; ++i) {
        time_us += 30'000 + 1'000 * static_cast<std::uint64_t>(i);
        PointCloud cloud = ball(400, i);
        if (!normals) cloud.normals.clear();
        EXPECT_TRUE(writer.add(record_frame(cloud, time_us).value()));
      }
      EXPECT_TRUE(writer.finish());
    }
    return recordings;
  }

  std::string join_error() {
    const Result<JoinReport> joined = join_parts(reel_);
    return joined ? "" : joined.error().message;
  }

  fs::path folder() const { return parts_folder(reel_); }
};

TEST_F(Parts, give_the_same_bytes_as_one_process) {
  const auto expected = whole(options());
  for (const std::uint32_t count : {1u, 2u, 7u, 10u}) {
    make(options());
    std::uint32_t packed = 0;
    for (std::uint32_t i = count; i >= 1; --i) {
      const Result<PartReport> report = part(i, count);
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_TRUE(report->failures.empty());
      packed += report->packed;
    }
    EXPECT_EQ(packed, 7u);
    const Result<JoinReport> joined = join_parts(reel_);
    ASSERT_TRUE(joined) << joined.error().message;
    EXPECT_EQ(joined->frames, kFrames);
    EXPECT_TRUE(contents(reel_) == expected) << count;
    EXPECT_FALSE(fs::exists(folder()));
    fs::remove_all(reel_);
  }
}

TEST_F(Parts, use_the_options_of_the_plan) {
  const std::vector<std::string> arguments = {"--quality=30", "--bitrate=400k", "--up=z",
                                              "--fps=12.5"};
  const PackOptions one = options(arguments);
  const auto expected = whole(one);
  make(one, arguments);
  ASSERT_TRUE(part(1, 1));
  EXPECT_EQ(join_error(), "");
  EXPECT_TRUE(contents(reel_) == expected);
}

TEST_F(Parts, keep_gaps_between_frames) {
  fs::rename(frames_ / "frame20.ply", frames_ / "frame30.ply");
  const PackOptions one = options({"--keep-gaps"});
  const auto expected = whole(one);
  make(one, {"--keep-gaps"});
  for (std::uint32_t i = 1; i <= 3; ++i) ASSERT_TRUE(part(i, 3));
  EXPECT_EQ(join_error(), "");
  EXPECT_EQ(read_manifest(reel_)->duration_us, 1'000'000u);
  EXPECT_TRUE(contents(reel_) == expected);
}

TEST_F(Parts, clean_all_frames_or_none_where_noise_is_about_at_the_limit) {
  // By themselves, some frames would be cleaned and others not: about 5 and about 16 of them.
  for (const auto& [less, more, cleaned] :
       {std::tuple{0.0105f, 0.0135f, 0}, std::tuple{0.013f, 0.017f, kFrames}}) {
    for (int i = 1; i <= kFrames; ++i) {
      PointCloud cloud = ball(2000, i);
      for (glm::vec3& p : cloud.positions)
        p *= 1.0f + (i % 3 == 0 ? more : less) * std::sin(1e4f * p.x + 3e4f * p.y);
      ASSERT_TRUE(write_ply(frames_ / fmt::format("frame{}.ply", i), cloud));
    }
    PackOptions one = options({"--clean=auto"});
    one.force = true;
    const auto expected = whole(one);
    make(one, {"--clean=auto"});
    ASSERT_TRUE(part(1, 2));
    ASSERT_TRUE(part(2, 2));
    EXPECT_EQ(join_error(), "");
    EXPECT_EQ(read_manifest(reel_)->cleaning.value_or(Cleaning{}).frames, cleaned);
    EXPECT_TRUE(contents(reel_) == expected);
  }
}

TEST_F(Parts, clean_their_frames_with_those_of_other_parts) {
  for (int i = 1; i <= kFrames; ++i) {
    PointCloud cloud = ball(2000, i);
    for (glm::vec3& p : cloud.positions) p *= 1.0f + 0.03f * std::sin(1e4f * p.x + 3e4f * p.y);
    ASSERT_TRUE(write_ply(frames_ / fmt::format("frame{}.ply", i), cloud));
  }
  const PackOptions one = options({"--clean=auto"});
  EXPECT_EQ(one.clean_frames, 2u);
  const auto expected = whole(one);
  make(one, {"--clean=auto"});
  for (std::uint32_t i = 1; i <= 4; ++i) ASSERT_TRUE(part(i, 4));
  EXPECT_EQ(join_error(), "");
  EXPECT_EQ(read_manifest(reel_)->cleaning.value_or(Cleaning{}).frames, kFrames);
  EXPECT_TRUE(contents(reel_) == expected);
}

TEST_F(Parts, estimate_the_normals_that_their_frames_lack) {
  for (int i = 1; i <= kFrames; ++i) {
    PointCloud cloud = ball(2000, i);
    cloud.normals.clear();
    ASSERT_TRUE(write_ply(frames_ / fmt::format("frame{}.ply", i), cloud));
  }
  const PackOptions one = options({"--normals=estimate"});
  const auto expected = whole(one);
  make(one, {"--normals=estimate"});
  for (std::uint32_t i = 1; i <= 3; ++i) ASSERT_TRUE(part(i, 3));
  EXPECT_EQ(join_error(), "");
  const Result<Manifest> manifest = read_manifest(reel_);
  ASSERT_TRUE(manifest);
  EXPECT_TRUE(manifest->normals && manifest->normals_estimated);
  EXPECT_TRUE(contents(reel_) == expected);
}

TEST_F(Parts, share_tables_that_were_learnt_once) {
  const PackOptions one = options({"--train"});
  const auto expected = whole(one);
  make(one, {"--train"});
  for (std::uint32_t i = 1; i <= 3; ++i) ASSERT_TRUE(part(i, 3));
  EXPECT_EQ(join_error(), "");
  EXPECT_TRUE(contents(reel_) == expected);
}

TEST_F(Parts, get_their_sound_when_they_are_joined) {
  PackOptions one = options();
  one.audio = reel_.parent_path() / "tone.wav";
  write_wav(*one.audio, 48000, 4800, [](std::uint32_t n) { return 0.3 * std::sin(0.06 * n); });
  const auto expected = whole(one);
  make(one);
  ASSERT_TRUE(part(1, 1));
  EXPECT_EQ(join_error(), "");
  EXPECT_TRUE(contents(reel_) == expected);
}

TEST_F(Parts, go_on_after_an_interruption_with_what_is_missing) {
  const auto expected = whole(options());
  make(options());
  std::stop_source stop;
  int frames = 0;
  PackListener listener;
  listener.stop = stop.get_token();
  listener.frame_done = [&] {
    if (++frames == 8) stop.request_stop();
  };
  const Result<PartReport> stopped = part(1, 1, false, listener);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
  EXPECT_THAT(join_error(), HasSubstr("5 of 7 segments are missing, the first at frame 6"));
  // What a process that was killed leaves behind.
  fs::create_directory(folder() / ".00006-elsewhere-17");
  std::ofstream(folder() / ".00006-elsewhere-17/00006.base.prs") << "half";

  const Result<PartReport> rest = part(1, 1);
  ASSERT_TRUE(rest);
  EXPECT_EQ(rest->already, 2u);
  EXPECT_EQ(rest->packed, 5u);
  EXPECT_EQ(join_error(), "");
  EXPECT_TRUE(contents(reel_) == expected);
}

TEST_F(Parts, may_run_twice_at_once) {
  const auto expected = whole(options());
  make(options());
  std::thread other([&] { EXPECT_TRUE(part(1, 1)); });
  EXPECT_TRUE(part(1, 1));
  other.join();
  EXPECT_EQ(join_error(), "");
  EXPECT_TRUE(contents(reel_) == expected);
}

TEST_F(Parts, report_a_frame_that_cannot_be_read_and_pack_the_rest) {
  std::ofstream(frames_ / "frame8.ply") << "ply\nnonsense\n";
  make(options());
  const Result<PartReport> first = part(1, 1, true);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->packed, 2u);
  const Result<PartReport> report = part(1, 1);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->packed, 4u);
  ASSERT_EQ(report->failures.size(), 1u);
  EXPECT_THAT(report->failures.front().message, HasSubstr("frame8.ply"));
  EXPECT_THAT(join_error(), HasSubstr("1 of 7 segments are missing, the first at frame 6"));
}

TEST_F(Parts, estimate_the_normals_that_recordings_lack) {
  const std::vector<std::string> arguments = {"--normals=estimate"};
  PackOptions one = options(arguments);
  one.inputs = {write_recordings(false)};
  const auto expected = whole(one);
  make(one, arguments);
  ASSERT_TRUE(part(1, 2) && part(2, 2));
  EXPECT_EQ(join_error(), "");
  EXPECT_TRUE(read_manifest(reel_)->normals_estimated);
  EXPECT_TRUE(contents(reel_) == expected);
}

TEST_F(Parts, take_frames_of_recordings_at_their_times) {
  PackOptions one = options();
  one.inputs = {write_recordings(true)};
  const auto expected = whole(one);
  make(one);
  for (std::uint32_t i = 1; i <= 3; ++i) {
    const Result<PartReport> report = part(i, 3);
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_TRUE(report->failures.empty()) << report->failures.front().message;
  }
  EXPECT_EQ(join_error(), "");
  EXPECT_TRUE(contents(reel_) == expected);
  EXPECT_EQ(read_manifest(reel_)->segments.front().times_us[2], 63'000u);
  EXPECT_EQ(read_manifest(reel_)->captured_us, 1'700'000'000'030'000u);
}

TEST_F(Parts, take_pictures_of_depth) {
  const fs::path capture = reel_.parent_path() / "capture";
  fs::create_directory(capture);
  depth_scene::write(capture, kFrames, depth_scene::camera(40));
  PackOptions one = options();
  one.inputs = {capture};
  const auto expected = whole(one);
  make(one);
  ASSERT_TRUE(part(1, 2) && part(2, 2));
  EXPECT_EQ(join_error(), "");
  EXPECT_TRUE(contents(reel_) == expected);
  EXPECT_EQ(read_manifest(reel_)->up, 'y');

  // The parts of an output in the capture are none of its files, and dangling links none at all.
  fs::create_symlink("nowhere", capture / "depth/99.png");
  PackOptions inside = one;
  inside.output = capture / "reel";
  ASSERT_TRUE(make_plan(inside, {}));
  EXPECT_THAT(pack_part(*read_plan(inside.output), inside, {1, 1}, false)->failures,
              testing::IsEmpty());

  fs::remove_all(reel_);
  make(one);
  fs::resize_file(capture / "depth/3.png", 10);
  const Result<PartReport> report = part(1, 7);
  ASSERT_TRUE(report);
  ASSERT_EQ(report->failures.size(), 1u);
  EXPECT_THAT(report->failures.front().message, HasSubstr("capture: has"));
  EXPECT_THAT(report->failures.front().message, HasSubstr("make the plan again"));
}

TEST_F(Parts, refuse_files_that_have_changed) {
  make(options());
  ASSERT_TRUE(write_ply(frames_ / "frame2.ply", ball(999, 1)));
  const Result<PartReport> report = part(1, 7);
  ASSERT_TRUE(report);
  ASSERT_EQ(report->failures.size(), 1u);
  EXPECT_THAT(report->failures.front().message, HasSubstr("make the plan again"));
}

TEST_F(Parts, are_not_joined_if_a_file_is_cut_off) {
  make(options());
  ASSERT_TRUE(part(1, 1));
  for (const auto& entry : fs::directory_iterator(folder())) {
    if (entry.path().filename().string().starts_with("00003.base")) fs::resize_file(entry, 10);
  }
  EXPECT_THAT(join_error(), HasSubstr("has 10 bytes instead of"));
  EXPECT_FALSE(fs::exists(reel_));
  EXPECT_TRUE(fs::exists(folder()));
}

TEST_F(Parts, need_a_plan_that_fits) {
  PackOptions timed = options();
  timed.frame_time_ms = 5.0;
  const auto refused = make_plan(timed, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("--frame-time"));
  EXPECT_FALSE(read_plan(reel_));
  EXPECT_EQ(read_plan(reel_).error().code, ErrorCode::not_found);

  make(options());
  EXPECT_THAT(make_plan(options(), {}).error().message, HasSubstr("a plan is there already"));
  PackOptions force = options();
  force.force = true;
  ASSERT_TRUE(part(1, 1));
  make(force);
  EXPECT_THAT(join_error(), HasSubstr("7 of 7"));

  // A program of an earlier version that was killed may have left it.
  fs::remove_all(folder());
  fs::create_directory(folder());
  make(options());

  std::ofstream(folder() / "plan.json") << R"({"my": "plan"})";
  std::ofstream(folder() / "thesis.txt") << "precious";
  EXPECT_THAT(make_plan(force, {}).error().message, HasSubstr("is not the folder of a plan"));
  EXPECT_EQ(read_text(folder() / "thesis.txt"), "precious");
  fs::remove_all(folder());

  fs::create_directory(reel_);
  std::ofstream(reel_ / "mine.txt") << "mine";
  EXPECT_FALSE(make_plan(options(), {}));
  EXPECT_FALSE(make_plan(force, {}));
  EXPECT_EQ(read_text(reel_ / "mine.txt"), "mine");
}

TEST_F(Parts, do_not_trust_a_damaged_plan) {
  make(options(), {"--up=z"});
  const fs::path path = folder() / "plan.json";
  const std::string text = read_text(path);
  for (std::size_t size = 0; size + 1 < text.size(); size += 7) {
    std::ofstream(path, std::ios::binary) << text.substr(0, size);
    const Result<PackPlan> plan = read_plan(reel_);
    ASSERT_FALSE(plan) << size;
    EXPECT_THAT(plan.error().message, HasSubstr("is damaged"));
  }
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    std::ofstream(path, std::ios::binary) << changed;
    const Result<PackPlan> plan = read_plan(reel_);
    return plan ? "" : plan.error().message;
  };
  EXPECT_THAT(with("\"segment_frames\": 3", "\"segment_frames\": 0"), HasSubstr("is damaged"));
  EXPECT_THAT(with("\"segment_frames\": 3", "\"segment_frames\": -3"), HasSubstr("is damaged"));
  EXPECT_THAT(with("\"up\": null", "\"up\": \"+x\""), HasSubstr("is damaged"));
  EXPECT_THAT(with("\"program\": \"0.1.0\"", "\"program\": \"9\""),
              HasSubstr("was made by version 9"));
  const Result<PackOptions> unknown = parse_pack_command_line({"--no-such-option"});
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message, HasSubstr("no-such-option"));
}

TEST(PackCommandLine, stands_for_the_options_that_were_given) {
  cli::Program app;
  PackArguments arguments;
  arguments.add_to(app);
  ASSERT_TRUE(app.parse({"-i", "a", "b", "-o", "out", "--force", "--depth", "9", "--bitrate", "2M",
                         "--best-effort", "--name", "-x y"}));
  EXPECT_THAT(
      arguments.command_line(),
      testing::UnorderedElementsAre("--depth=9", "--bitrate=2M", "--best-effort", "--name=-x y"));
  const Result<PackOptions> options = parse_pack_command_line(arguments.command_line());
  ASSERT_TRUE(options);
  EXPECT_EQ(options->name, "-x y");
  EXPECT_EQ(options->bitrate, 2e6);
  EXPECT_TRUE(options->best_effort);
  EXPECT_FALSE(options->force);
}

TEST(PackCommandLine, leaves_the_codec_to_a_trial_unless_an_option_asks_for_one) {
  const auto open = [](const std::vector<std::string>& arguments) {
    const Result<PackOptions> options = parse_pack_command_line(arguments);
    EXPECT_TRUE(options) << options.error().message;
    return options && options->video_if_it_pays;
  };
  EXPECT_TRUE(open({}));
  EXPECT_TRUE(open({"--quality=80", "--bitrate=4M", "--clean=auto", "--no-normals"}));
  for (const char* asking :
       {"--codec=octree", "--codec=video", "--depth=9", "--delta=0.1", "--voxel=1", "--spacing=1",
        "--quality=100", "--no-scalars", "--train", "--cube=frame", "--frame-time=30"})
    EXPECT_FALSE(open({asking})) << asking;
  const Result<PackOptions> short_segments = parse_pack_command_line({"--segment=7"});
  ASSERT_TRUE(short_segments && short_segments->video_if_it_pays);
  EXPECT_EQ(short_segments->video_if_it_pays->segment_frames, 7u);
}

TEST(PackCommandLine, keeps_values_that_begin_with_a_minus_sign_and_no_empty_ones) {
  cli::Program app;
  PackArguments arguments;
  arguments.add_to(app);
  ASSERT_TRUE(app.parse({"--name", "", "--scalar-step", "a=1", "--scalar-step=-b=2"}));
  EXPECT_THAT(arguments.command_line(),
              testing::UnorderedElementsAre("--scalar-step=a=1", "--scalar-step=-b=2"));
  EXPECT_TRUE(parse_pack_command_line(arguments.command_line()));
}

TEST(PackCommandLine, refuses_options_that_others_make_useless) {
  for (const auto& [arguments, message] :
       std::initializer_list<std::pair<std::vector<std::string>, const char*>>{
           {{"--clean=off", "--clean-frames=3"}, "--clean-frames does nothing with --clean off"},
           {{"--no-normals", "--normal-quality=90"},
            "--normal-quality does nothing with --normals derive"},
           {{"--no-scalars", "--scalar-step=heat=1"},
            "--scalar-step does nothing with --no-scalars"}}) {
    const Result<PackOptions> options = parse_pack_command_line(arguments);
    ASSERT_FALSE(options);
    EXPECT_EQ(options.error().message, message);
  }
}

TEST(PartOf, shares_segments_out_evenly) {
  for (const std::uint32_t segments : {0u, 1u, 6u, 7u, 100u}) {
    std::uint32_t next = 0;
    for (std::uint32_t i = 1; i <= 7; ++i) {
      const PartOf part{i, 7};
      EXPECT_EQ(part.first_segment(segments), next);
      next = part.end_segment(segments);
      EXPECT_LE(next - part.first_segment(segments), segments / 7 + 1);
    }
    EXPECT_EQ(next, segments);
  }
}

}  // namespace
}  // namespace pointreel::parts_test
