#include <cmath>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/package/manifest.h"
#include "common/command_line/command.h"
#include "common/process/ffmpeg.h"
#include "server/commands/bit_rates.h"
#include "server/commands/commands.h"
#include "tests/packed_reel.h"
#include "tests/tone.h"

namespace pointreel::pack_command_test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

struct Outcome {
  int code = -1;
  std::string out, errors;
};

/// Runs a command line of pointreel-server in this process. The exit code is 2 if it is refused.
Outcome run(const std::vector<std::string>& arguments) {
  Outcome outcome;
  cli::Program app;
  add_pack_command(app, outcome.code);
  add_inspect_commands(app, outcome.code);
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const auto parsed = app.parse(arguments);
  if (!parsed) outcome.code = kExitUsage;
  std::fflush(stdout);
  outcome.out = testing::internal::GetCapturedStdout();
  outcome.errors = testing::internal::GetCapturedStderr() + (parsed ? "" : parsed.error().message);
  return outcome;
}

class PackCommand : public PackTest {
 protected:
  Outcome run_pack(const std::vector<std::string>& more) {
    std::vector<std::string> all = {"pack", "-i", frames_.string(), "-o", reel_.string()};
    all.insert(all.end(), more.begin(), more.end());
    return run(all);
  }
};

TEST_F(PackCommand, prints_its_summary_as_json_and_nothing_else) {
  write_frames(3);
  const Outcome outcome = run_pack({"--depth", "9", "--json"});
  EXPECT_EQ(outcome.code, kExitOk);
  EXPECT_EQ(outcome.errors, "");
  const json summary = json::parse(outcome.out);
  EXPECT_EQ(summary.at("frames"), 3);
  EXPECT_EQ(summary.at("points"), 201 + 202 + 203);
  EXPECT_EQ(summary.at("depth"), (json{{"min", 9}, {"max", 9}}));
  EXPECT_EQ(summary.at("entropy"), "context");
  const json& bits = summary.at("bits_per_point");
  EXPECT_NEAR(bits.at("geometry").get<double>() + bits.at("colors").get<double>() +
                  bits.at("normals").get<double>(),
              bits.at("total").get<double>(), 1e-9);
  EXPECT_LE(summary.at("encode_ms").at("min"), summary.at("encode_ms").at("max"));
}

TEST_F(PackCommand, reports_the_parts_of_draco_frames_only_on_request) {
  write_frames(1);
  const auto bits_per_point = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = {"--codec", "draco", "--force", "--json"};
    all.insert(all.end(), more.begin(), more.end());
    return json::parse(run_pack(all).out).at("bits_per_point");
  };
  const json total = bits_per_point({});
  EXPECT_EQ(total.size(), 1u);
  const json parts = bits_per_point({"--measure-parts"});
  EXPECT_EQ(parts.at("total"), total.at("total"));
  EXPECT_NEAR(parts.at("geometry").get<double>() + parts.at("colors").get<double>() +
                  parts.at("normals").get<double>(),
              parts.at("total").get<double>(), 1e-9);
  EXPECT_THAT(run_pack({"--codec", "draco", "--force"}).out, testing::Not(HasSubstr("(geometry")));
  EXPECT_EQ(run_pack({"--measure-parts", "--force"}).code, kExitUsage);
}

TEST_F(PackCommand, reports_how_a_bit_rate_changed_each_segment) {
  write_frames(4);
  const Outcome asked = run_pack({"--segment", "2", "--depth", "9", "--json"});
  const json before = json::parse(asked.out).at("segments");
  ASSERT_EQ(before.size(), 2u);
  const double rate = 0.4 * before[0].at("bits_per_second").get<double>();
  const Outcome outcome = run_pack({"--segment", "2", "--depth", "9", "--force", "--json",
                                    "--bitrate", std::to_string(1e-3 * rate) + "k"});
  ASSERT_EQ(outcome.code, kExitOk) << outcome.errors;
  std::uint32_t frame = 0;
  const json after = json::parse(outcome.out).at("segments");
  for (const json& segment : after) {
    EXPECT_EQ(segment.at("first_frame"), frame);
    EXPECT_EQ(segment.at("frames"), 2);
    EXPECT_LE(segment.at("bits_per_second").get<double>(), rate);
    EXPECT_LE(segment.at("depth").at("max"), 9);
    EXPECT_LT(segment.at("quality"), kDefaultColorQuality);
    EXPECT_TRUE(segment.at("within_bitrate").get<bool>());
    EXPECT_GT(segment.at("max_error").get<double>(), 0.0);
    frame += 2;
  }
  const Outcome people = run_pack({"--segment", "2", "--force", "--bitrate", "20M"});
  EXPECT_THAT(people.out, HasSubstr("frames     2 to     3"));
  EXPECT_THAT(people.out, HasSubstr("error "));
}

TEST_F(PackCommand, tells_the_bit_rate_over_the_time_that_the_reel_lasts_as_info_does) {
  write_frames(6);
  for (const int missing : {3, 4, 5})
    std::filesystem::remove(frames_ / ("frame" + std::to_string(missing) + ".ply"));
  const Outcome packed = run_pack({"--keep-gaps", "--fps", "10", "--json"});
  ASSERT_EQ(packed.code, kExitOk) << packed.errors;
  const json summary = json::parse(packed.out);
  EXPECT_NEAR(summary.at("duration_s"), 0.6, 1e-9) << "and not 0.3";
  const json info = json::parse(run({"info", reel_.string(), "--json"}).out);
  double bytes = 0.0;
  for (const json& layer : info.at("layers")) bytes += layer.at("bytes").get<double>();
  EXPECT_NEAR(summary.at("bits_per_second").at("frames"), 8.0 * bytes / 0.6, 1e-3);
  EXPECT_EQ(summary.at("bits_per_second").at("audio"), 0.0);
  EXPECT_EQ(info.at("bits_per_second"), summary.at("bits_per_second"));
  const std::string rate = bit_rates_text({8.0 * bytes / 0.6, 0.0});
  EXPECT_THAT(run({"info", reel_.string()}).out, HasSubstr(", " + rate + "\n"));
  EXPECT_THAT(run_pack({"--keep-gaps", "--fps", "10", "--force"}).out,
              HasSubstr("bit rate        " + rate + "\n"));
}

TEST_F(PackCommand, tells_what_became_of_the_sound) {
  if (!is_installed("ffmpeg")) GTEST_SKIP() << "ffmpeg is not installed";
  write_frames(2);
  const auto sound = folder_.path() / "a.wav";
  write_wav(sound, 44'100, 44'100, [](std::uint32_t n) { return std::sin(0.05 * n); });
  const Outcome told = run_pack({"--fps", "10", "--audio", sound.string()});
  EXPECT_THAT(told.out, HasSubstr("sound           0.2 s of 1 s (the rest was cut off)\n"));
  EXPECT_THAT(told.out, HasSubstr(" Mbit/s of sound\n"));
  const json summary =
      json::parse(run_pack({"--fps", "10", "--audio", sound.string(), "--force", "--json"}).out);
  EXPECT_NEAR(summary.at("audio").at("duration_s"), 0.2, 1e-6);
  EXPECT_NEAR(summary.at("audio").at("source_s"), 1.0, 1e-6);
  EXPECT_TRUE(summary.at("audio").at("cut_off").get<bool>());
  EXPECT_NEAR(summary.at("bits_per_second").at("audio"),
              8.0 * summary.at("audio").at("bytes").get<double>() / 0.2, 1e-3);
  EXPECT_TRUE(json::parse(run_pack({"--force", "--json"}).out).at("audio").is_null());
}

TEST(BitRates, tell_sound_apart_from_frames) {
  EXPECT_EQ(bit_rates_text(bit_rates(500'000, 32'000, 2'000'000)),
            "2 Mbit/s, and 0.128 Mbit/s of sound");
  EXPECT_EQ(bit_rates_text(bit_rates(500'000, 0, 0)), "0 Mbit/s");
}

TEST_F(PackCommand, writes_no_json_among_what_it_reads_and_writes) {
  for (const auto& folder : {frames_, reel_}) {
    const Outcome refused = run_pack({"--json", (folder / "summary.json").string()});
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(refused.errors.find("lies in " + folder.string()), std::string::npos)
        << refused.errors;
    EXPECT_FALSE(std::filesystem::exists(folder / "summary.json"));
  }
}

TEST_F(PackCommand, writes_json_to_a_file_and_prints_a_summary_for_people) {
  write_frames(1);
  const auto path = folder_.path() / "pack.json";
  const Outcome outcome = run_pack({"--json", path.string()});
  EXPECT_EQ(outcome.code, kExitOk);
  EXPECT_THAT(outcome.out, HasSubstr("1 frame,"));
  EXPECT_EQ(json::parse(read_text(path)).at("frames"), 1);
}

TEST_F(PackCommand, refuses_options_that_contradict_each_other) {
  write_frames(1);
  const std::vector<std::vector<std::string>> wrong = {{"--delta", "0.1", "--depth", "3"},
                                                       {"--delta", "0.1", "--voxel", "1"},
                                                       {"--depth", "3", "--voxel", "1"},
                                                       {"--codec", "draco", "--depth", "3"},
                                                       {"--codec", "draco", "--entropy", "none"},
                                                       {"--codec", "draco", "--train"},
                                                       {"--codec", "draco", "--slabs", "2"},
                                                       {"--slabs", "2", "--entropy", "none"},
                                                       {"--slabs", "17"},
                                                       {"--train", "--entropy", "zstd"},
                                                       {"--codec", "draco", "--quality", "50"},
                                                       {"--quality", "0"},
                                                       {"--quality", "101"},
                                                       {"--normal-quality", "0"},
                                                       {"--normals", "guess"},
                                                       {"--normals", "send", "--no-normals"},
                                                       {"--qp", "11"},
                                                       {"--delta", "nan"},
                                                       {"--delta", "-0.1"},
                                                       {"--delta", "x"},
                                                       {"--depth", "22"},
                                                       {"--depth", "-1"},
                                                       {"--voxel", "0"},
                                                       {"--voxel", "nan"},
                                                       {"--voxel", "inf"},
                                                       {"--clean", "0"},
                                                       {"--clean", "nan"},
                                                       {"--clean", "much"},
                                                       {"--fps", "0"},
                                                       {"--fps", "nan"},
                                                       {"--bitrate", "20Q"},
                                                       {"--bitrate", "0"},
                                                       {"--bitrate", "-3M"},
                                                       {"--bitrate", "M"},
                                                       {"--bitrate", "nan"},
                                                       {"--bitrate", "2MM"},
                                                       {"--frame-time", "0"},
                                                       {"--frame-time", "nan"},
                                                       {"--method", "kd-tree"},
                                                       {"--codec", "draco", "--method", "x"},
                                                       {"--segment", "0"},
                                                       {"--up", "w"},
                                                       {"--codec", "mp4"},
                                                       {"--cube", "none"},
                                                       {"--threads", "-1"},
                                                       {"--name", "gnp.\u202exe"},
                                                       {"--name", std::string(5000, 'x')},
                                                       {"--no-such-option"}};
  for (const auto& arguments : wrong) {
    const Outcome outcome = run_pack(arguments);
    EXPECT_EQ(outcome.code, kExitUsage) << testing::PrintToString(arguments);
    EXPECT_NE(outcome.errors, "") << testing::PrintToString(arguments);
  }
  EXPECT_TRUE(outputs().empty());
}

TEST_F(PackCommand, takes_paths_by_their_place_or_by_name) {
  write_frames(3);
  const std::string in = frames_.string(), reel = reel_.string();
  ASSERT_EQ(run({"pack", in, reel}).code, kExitOk);
  EXPECT_EQ(read_manifest(reel_)->frame_count(), 3u);
  ASSERT_EQ(run({"pack", in, in, reel, "--force"}).code, kExitOk);
  EXPECT_EQ(read_manifest(reel_)->frame_count(), 6u);
  ASSERT_EQ(run({"pack", "-i", in, "--force", "--", reel}).code, kExitOk);
  EXPECT_EQ(read_manifest(reel_)->frame_count(), 3u);
  EXPECT_EQ(run({"info", "-i", reel}).code, kExitOk);
  EXPECT_EQ(run({"unpack", reel, reel + ".files"}).code, kExitOk);

  for (const std::vector<std::string>& wrong : std::vector<std::vector<std::string>>{
           {"pack"}, {"pack", in}, {"pack", "-i", in}, {"pack", "-o", reel}}) {
    const Outcome outcome = run(wrong);
    EXPECT_EQ(outcome.code, kExitUsage) << testing::PrintToString(wrong);
    EXPECT_NE(outcome.errors.find("pack FOLDER REEL"), std::string::npos) << outcome.errors;
  }
  const Outcome twice = run({"pack", "-i", in, "-o", reel, "--force", "--", in});
  EXPECT_EQ(twice.code, kExitUsage);
  EXPECT_NE(twice.errors.find("is not needed beside"), std::string::npos) << twice.errors;
}

TEST_F(PackCommand, writes_fewer_bytes_for_colours_of_lower_quality) {
  write_frames(1);
  double last = 0.0;
  for (const char* quality : {"20", "60", "100"}) {
    const Outcome outcome = run_pack({"--quality", quality, "--depth", "8", "--force", "--json"});
    ASSERT_EQ(outcome.code, kExitOk) << outcome.errors;
    const double bits = json::parse(outcome.out).at("bits_per_point").at("colors").get<double>();
    EXPECT_GT(bits, last) << quality;
    last = bits;
  }
}

TEST_F(PackCommand, does_not_send_normals_that_clients_can_derive) {
  write_frames(1);
  const auto bits_of_normals = [&](const std::vector<std::string>& how) {
    std::vector<std::string> all = {"--depth", "8", "--force", "--json"};
    all.insert(all.begin(), how.begin(), how.end());
    const Outcome outcome = run_pack(all);
    EXPECT_EQ(outcome.code, kExitOk) << outcome.errors;
    return json::parse(outcome.out).at("bits_per_point").at("normals").get<double>();
  };
  const double sent = bits_of_normals({"--normals", "send"});
  EXPECT_GT(sent, 0.0);
  EXPECT_GT(bits_of_normals({"--normal-quality", "90"}), sent);
  EXPECT_GE(bits_of_normals({"--normal-quality", "43"}), sent);
  EXPECT_EQ(bits_of_normals({"--normals", "derive"}), 0.0);
  EXPECT_EQ(bits_of_normals({"--no-normals"}), 0.0);
}

TEST_F(PackCommand, names_the_option_whose_voxels_cannot_be_coded) {
  write_frames(1);
  for (const std::string option : {"--voxel", "--spacing"}) {
    for (const std::string size : {"1e300", "1e-300"}) {
      const Outcome outcome = run_pack({option, size});
      EXPECT_EQ(outcome.code, kExitFailed) << option << " " << size;
      EXPECT_THAT(outcome.errors, testing::HasSubstr(option)) << size;
    }
  }
}

TEST_F(PackCommand, exits_with_1_and_prints_one_line_when_it_fails) {
  const Outcome outcome = run_pack({});
  EXPECT_EQ(outcome.code, kExitFailed);
  EXPECT_THAT(outcome.errors, testing::StartsWith("pointreel-server: "));
  EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1);
}

TEST_F(PackCommand, verify_distinguishes_good_packages_faulty_ones_and_other_folders) {
  write_frames(2);
  ASSERT_EQ(run_pack({}).code, kExitOk);
  EXPECT_EQ(run({"verify", reel_.string()}).code, kExitOk);
  EXPECT_EQ(run({"verify", frames_.string()}).code, kExitUsage);
  const std::string name = read_manifest(reel_)->segments[0].layers[0].path;
  std::string bytes = read_text(reel_ / name);
  bytes.back() = static_cast<char>(bytes.back() ^ 1);
  write_file(reel_ / name, bytes);
  const Outcome outcome = run({"verify", reel_.string(), "--json"});
  EXPECT_EQ(outcome.code, kExitFailed);
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report.at("good"), false);
  EXPECT_EQ(report.at("faults")[0].at("file"), name);
  EXPECT_EQ(report.at("faults")[1].at("frame"), 1);
  EXPECT_THAT(run({"verify", reel_.string()}).out, HasSubstr(name + ": frame 1: "));
}

TEST_F(PackCommand, a_damaged_manifest_is_a_fault_and_a_missing_one_is_wrong_usage) {
  write_frames(1);
  ASSERT_EQ(run_pack({}).code, kExitOk);
  const std::string back = (folder_.path() / "back").string();
  const std::string good = read_text(reel_ / kManifestName);
  for (const std::string& damaged :
       {std::string(), std::string("{"), good.substr(0, good.size() / 2),
        std::string(kMaxManifestBytes + 1, ' ')}) {
    write_file(reel_ / kManifestName, damaged);
    for (const char* command : {"info", "verify"}) {
      EXPECT_EQ(run({command, reel_.string()}).code, kExitFailed) << command;
    }
    EXPECT_EQ(run({"unpack", "-i", reel_.string(), "-o", back}).code, kExitFailed);
  }
  std::filesystem::remove(reel_ / kManifestName);
  for (const char* command : {"info", "verify"}) {
    EXPECT_EQ(run({command, reel_.string()}).code, kExitUsage) << command;
  }
  EXPECT_EQ(run({"unpack", "-i", reel_.string(), "-o", back}).code, kExitUsage);
}

TEST_F(PackCommand, a_folder_that_does_not_exist_is_not_called_a_package_without_a_manifest) {
  for (const char* command : {"info", "verify"}) {
    const Outcome outcome = run({command, reel_.string()});
    EXPECT_EQ(outcome.code, kExitUsage) << command;
    EXPECT_THAT(outcome.errors, HasSubstr(reel_.string() + ": no such file or folder"));
  }
}

TEST_F(PackCommand, verify_detects_a_missing_layer_even_if_it_adds_no_points) {
  write_frames(1);
  ASSERT_EQ(run_pack({"--depth", "11"}).code, kExitOk);
  Manifest manifest = *read_manifest(reel_);
  ASSERT_EQ(manifest.layer_names.size(), 3u);
  manifest.layer_names.pop_back();
  manifest.segments[0].layers.pop_back();
  write_file(reel_ / kManifestName, write_manifest(manifest));
  const Outcome outcome = run({"verify", reel_.string()});
  EXPECT_EQ(outcome.code, kExitFailed);
  EXPECT_THAT(outcome.out, HasSubstr("frame 0: has 2 layers, its header says 3"));
}

TEST_F(PackCommand, info_prints_enough_digits_of_bounds_far_from_zero) {
  write_frames(1);
  ASSERT_EQ(run_pack({}).code, kExitOk);
  Manifest manifest = *read_manifest(reel_);
  manifest.bounds = {{498'062.0, 7'050'992.84, 74.34}, {498'067.39, 7'050'997.04, 80.02}};
  write_file(reel_ / kManifestName, write_manifest(manifest));
  EXPECT_THAT(run({"info", reel_.string()}).out,
              HasSubstr("(498062, 7050992.84, 74.34) to (498067.39, 7050997.04, 80.02)"));
}

TEST_F(PackCommand, the_time_of_capture_goes_into_recordings_and_comes_back) {
  constexpr std::uint64_t kCaptured = 1'781'280'005'250'000;
  write_frames(3);
  ASSERT_EQ(run_pack({}).code, kExitOk);
  EXPECT_EQ(json::parse(run({"info", reel_.string(), "--json"}).out).at("captured_us"), nullptr);
  Manifest manifest = *read_manifest(reel_);
  manifest.captured_us = kCaptured;
  write_file(reel_ / kManifestName, write_manifest(manifest));
  EXPECT_THAT(run({"info", reel_.string()}).out, HasSubstr("captured 2026-06-12 16:00:05 UTC"));
  const auto recording = reel_.parent_path() / "recording", again = reel_.parent_path() / "again";
  ASSERT_EQ(
      run({"unpack", "-i", reel_.string(), "-o", recording.string(), "--format", "mcap"}).code,
      kExitOk);
  ASSERT_EQ(run({"pack", "-i", recording.string(), "-o", again.string()}).code, kExitOk);
  EXPECT_EQ(read_manifest(again)->captured_us, kCaptured);
  EXPECT_EQ(read_manifest(again)->segments[0].times_us, manifest.segments[0].times_us);
  // Times from zero on are not those of a clock.
  manifest.captured_us.reset();
  write_file(reel_ / kManifestName, write_manifest(manifest));
  ASSERT_EQ(
      run({"unpack", "-i", reel_.string(), "-o", recording.string(), "--format", "mcap", "--force"})
          .code,
      kExitOk);
  ASSERT_EQ(run({"pack", "-i", recording.string(), "-o", again.string(), "--force"}).code, kExitOk);
  EXPECT_FALSE(read_manifest(again)->captured_us);
}

TEST_F(PackCommand, takes_what_unpack_has_written_in_any_format) {
  write_frames(2);
  ASSERT_EQ(run_pack({}).code, kExitOk);
  for (const auto& [format, up] :
       {std::pair("ply", "y"), {"pcd", "y"}, {"las", "z"}, {"mcap", "z"}}) {
    SCOPED_TRACE(format);
    const std::string files = (reel_.parent_path() / format).string(), again = files + ".reel";
    const Outcome unpacked = run({"unpack", reel_.string(), files, "--format", format});
    ASSERT_EQ(unpacked.code, kExitOk);
    EXPECT_EQ(unpacked.errors.find("give --up y") != std::string::npos, up == std::string("z"));
    const Outcome packed = run({"pack", "-i", files, "-o", again});
    ASSERT_EQ(packed.code, kExitOk) << packed.errors;
    EXPECT_EQ(read_manifest(again)->up.text(), up);
    EXPECT_EQ(read_manifest(again)->frame_count(), 2u);
  }
}

TEST_F(PackCommand, any_axis_points_up) {
  write_frames(1);
  for (const char* up : {"x", "-x", "y", "-y", "z", "-z"}) {
    ASSERT_EQ(run_pack({"--up", up, "--force"}).code, kExitOk);
    EXPECT_EQ(read_manifest(reel_)->up.text(), up);
  }
  EXPECT_EQ(run_pack({"--up", "w", "--force"}).code, kExitUsage);
}

TEST_F(PackCommand, info_prints_the_contents_of_the_manifest) {
  write_frames(2);
  ASSERT_EQ(run_pack({"--fps", "25", "--up", "z", "--name", "ball game"}).code, kExitOk);
  const json info = json::parse(run({"info", reel_.string(), "--json"}).out);
  EXPECT_EQ(info.at("name"), "ball game");
  EXPECT_EQ(info.at("frames"), 2);
  EXPECT_EQ(info.at("up"), "z");
  EXPECT_EQ(info.at("points").at("max"), 202);
  EXPECT_DOUBLE_EQ(info.at("duration_s"), 0.08);
  EXPECT_THAT(run({"info", reel_.string()}).out, HasSubstr("ball game: 2 frames"));
  EXPECT_EQ(run({"info", frames_.string()}).code, kExitUsage);
}

TEST_F(PackCommand, unpack_writes_only_the_requested_range_of_frames) {
  write_frames(3);
  ASSERT_EQ(run_pack({}).code, kExitOk);
  const auto back = (folder_.path() / "back").string();
  for (const char* wrong : {"2-1", "-1", "1-", "a", "1-2-3", "", "99999999999", "3", "2-3"}) {
    EXPECT_NE(
        run({"unpack", "-i", reel_.string(), "-o", back, std::string("--frames=") + wrong}).code,
        kExitOk)
        << wrong;
  }
  EXPECT_EQ(run({"unpack", "-i", reel_.string(), "-o", back, "--frames", "1"}).code, kExitOk);
  EXPECT_EQ(contents(back).size(), 1u);
}

/// A line that ends early in the middle of a sentence comes from a line break in the source.
TEST(ServerHelp, breaks_the_lines_of_descriptions_only_where_the_next_word_does_not_fit) {
  int code = 0;
  cli::Program app("Description", "pointreel-server");
  add_pack_command(app, code);
  add_inspect_commands(app, code);
  add_publish_command(app, code);
  add_serve_command(app, code, {}, {});
  app.add_common_options();
  for (const cli::Command command : app.subcommands()) {
    std::istringstream lines(command.help_all());
    std::string last;
    for (std::string line; std::getline(lines, line) && !line.starts_with("Usage:"); last = line) {
      EXPECT_LE(line.size(), 80u) << line;
      if (line.empty() || line[0] < 'a' || line[0] > 'z') continue;
      EXPECT_GT(last.size() + 1 + line.find(' '), 80u) << command.name() << ": " << last;
    }
  }
}

}  // namespace
}  // namespace pointreel::pack_command_test
