// Packages that are cut and joined: the same bytes of segments, the same frames, the same sound.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/audio/opus_reader.h"
#include "codec/segments/append_manifest.h"
#include "common/process/ffmpeg.h"
#include "server/edit/cut_package.h"
#include "server/edit/join_packages.h"
#include "server/edit/splice_sound.h"
#include "server/inspect/inspect.h"
#include "tests/packed_reel.h"
#include "tests/read_file.h"
#include "tests/server/recorder_test.h"
#include "tests/tone.h"

namespace pointreel::edit_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kFrames = 20;  // 7 segments, the last of 2 frames

/// The bytes of each layer of each segment, in order.
std::vector<std::string> segments_of(const fs::path& package) {
  std::vector<std::string> segments;
  const Manifest manifest = read_manifest(package).value();
  for (const Segment& segment : manifest.segments)
    for (const LayerFile& file : segment.layers) segments.push_back(read_text(package / file.path));
  return segments;
}

std::vector<std::string> faults_of(const fs::path& package) {
  const auto report = verify(package);
  if (!report) return {report.error().message};
  std::vector<std::string> faults;
  for (const Fault& fault : report->faults) faults.push_back(fault.file + ": " + fault.what);
  return faults;
}

/// The decoded frames of a package, as files.
std::vector<std::string> frames_of(const fs::path& package) {
  const TemporaryFolder folder;
  const auto report = unpack({.input = package, .output = folder / "out"});
  EXPECT_TRUE(report) << report.error().message;
  std::vector<std::string> frames;
  for (auto& [name, content] : contents(folder / "out"))
    if (name.ends_with(".ply")) frames.push_back(std::move(content));
  return frames;
}

std::vector<std::string> part(const std::vector<std::string>& all, std::size_t begin,
                              std::size_t end) {
  return {all.begin() + static_cast<std::ptrdiff_t>(begin),
          all.begin() + static_cast<std::ptrdiff_t>(end)};
}

std::vector<StereoSample> sound_of(const fs::path& package) {
  const auto manifest = read_manifest(package).value();
  if (!manifest.audio) return {};
  const std::string text = read_text(package / manifest.audio->path);
  const Bytes bytes(text.begin(), text.end());
  auto reader = OpusReader::open(bytes);
  EXPECT_TRUE(reader);
  std::vector<StereoSample> samples(manifest.audio->samples);
  EXPECT_EQ(reader->samples(), samples.size());
  std::size_t size = 0;
  while (size < samples.size()) {
    const auto read = reader->read(std::span(samples).subspan(size));
    EXPECT_TRUE(read && !read->hole);
    if (!read || read->samples == 0) break;
    size += read->samples;
  }
  EXPECT_EQ(size, samples.size());
  return samples;
}

/// How far two sounds differ, from a sample on, as a share of what they have.
double difference(const std::vector<StereoSample>& a, std::size_t from_a,
                  const std::vector<StereoSample>& b, std::size_t from_b, std::size_t count) {
  double error = 0.0, power = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const StereoSample &x = a.at(from_a + i), &y = b.at(from_b + i);
    error += std::pow(x.left - y.left, 2) + std::pow(x.right - y.right, 2);
    power += x.left * x.left + x.right * x.right;
  }
  return std::sqrt(error / std::max(power, 1e-9));
}

/// A tone that rises, so that no part of it is like another.
double sweep(std::uint32_t n) {
  const double t = n / 48'000.0;
  return 0.5 * std::sin(2.0 * std::numbers::pi * (200.0 + 150.0 * t) * t);
}

class Edit : public PackTest {
 protected:
  void SetUp() override { write_frames(kFrames); }

  fs::path at(const std::string& name) const { return folder_ / name; }

  fs::path pack_as(const std::string& name, PackOptions options) const {
    options.output = at(name);
    options.name = "ball";
    const auto packed = pack(options);
    EXPECT_TRUE(packed) << packed.error().message;
    return at(name);
  }
  void write_sound(const std::string& name, std::uint32_t samples) const {
    write_wav(at(name), 48'000, samples, sweep);
  }

  Result<CutReport> cut(const fs::path& from, const std::string& to, std::uint32_t first,
                        std::uint32_t last) const {
    return cut_package({.input = from, .output = at(to), .frames = CutRange{first, last}});
  }
  Result<JoinedPackages> join(const std::vector<std::string>& names, const std::string& to,
                              bool force = false) const {
    JoinOptions options{.inputs = {}, .output = at(to), .force = force};
    for (const std::string& name : names) options.inputs.emplace_back(at(name));
    return join_packages(options);
  }
  std::string error(const Result<JoinedPackages>& joined) const {
    return joined ? "" : joined.error().message;
  }
};

TEST_F(Edit, a_cut_has_exactly_the_frames_from_time_0_on) {
  for (const PackOptions& options : {layered_options(), draco_options()}) {
    const fs::path reel = pack_as("reel", options);
    const Manifest whole = read_manifest(reel).value();
    for (const auto& [first, last] : {std::pair(4u, 10u), {4, 4}, {1, 1}, {3, 4}, {18, 19}}) {
      const auto report = cut(reel, "cut", first, last);
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_EQ(report->frames.first, first);
      EXPECT_EQ(report->frames.last, last);
      EXPECT_THAT(faults_of(at("cut")), IsEmpty());
      EXPECT_EQ(frames_of(at("cut")), part(frames_of(reel), first, last + 1));
      const Manifest kept = read_manifest(at("cut")).value();
      ASSERT_EQ(kept.frame_count(), last - first + 1);
      for (std::uint32_t i = 0; i < kept.frame_count(); ++i)
        EXPECT_EQ(frame_time_us(kept, i),
                  frame_time_us(whole, first + i) - frame_time_us(whole, first));
      EXPECT_EQ(kept.duration_us,
                (last == 19 ? whole.duration_us : frame_time_us(whole, last + 1)) -
                    frame_time_us(whole, first));
      fs::remove_all(at("cut"));
    }
    fs::remove_all(reel);
  }
}

TEST_F(Edit, a_cut_may_have_frames_without_points_alone) {
  for (int i = 5; i <= 9; ++i)
    ASSERT_TRUE(write_ply(frames_ / ("frame" + std::to_string(i) + ".ply"), PointCloud()));
  const fs::path reel = pack_as("reel", layered_options());
  const auto report = cut(reel, "cut", 5, 7);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_THAT(faults_of(at("cut")), IsEmpty());
  EXPECT_TRUE(read_manifest(at("cut"))->bounds.empty());
  EXPECT_EQ(error(join({"reel", "cut"}, "joined")), "");
}

TEST_F(Edit, a_cut_links_whole_segments) {
  const fs::path reel = pack_as("reel", layered_options());
  const auto report = cut(reel, "cut", 3, 11);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->frames.first, 3u);
  EXPECT_EQ(report->frames.last, 11u);
  EXPECT_EQ(report->segments, 3u);
  EXPECT_THAT(faults_of(at("cut")), IsEmpty());
  EXPECT_EQ(segments_of(at("cut")), part(segments_of(reel), 3, 12));
  EXPECT_EQ(frames_of(at("cut")), part(frames_of(reel), 3, 12));

  const Manifest whole = read_manifest(reel).value();
  Manifest kept = read_manifest(at("cut")).value();
  EXPECT_EQ(kept.frame_count(), 9u);
  for (std::uint32_t i = 0; i < 9; ++i)
    EXPECT_EQ(frame_time_us(kept, i), frame_time_us(whole, i + 3) - frame_time_us(whole, 3));
  EXPECT_EQ(kept.duration_us, frame_time_us(whole, 12) - frame_time_us(whole, 3));
  EXPECT_FALSE(kept.captured_us);
  EXPECT_EQ(std::exchange(kept.name, whole.name), "cut");
  EXPECT_EQ(static_cast<const ReelHead&>(kept), whole);
  EXPECT_EQ(kept.segments[1].layers[0].path.substr(0, 14), "00000003.base.");
  std::uint64_t bytes = 0;
  for (const auto& [name, content] : contents(at("cut"))) bytes += content.size();
  EXPECT_EQ(report->bytes, bytes);
  EXPECT_EQ(fs::hard_link_count(at("cut") / kept.segments[0].layers[0].path), 2u);
}

TEST_F(Edit, pieces_of_a_reel_that_are_joined_are_the_reel_again) {
  PackOptions trained = layered_options();
  trained.train = true;
  trained.encode.codec = OctreeOptions{Entropy::context, DepthRule::fixed(10)};
  for (const PackOptions& options : {layered_options(), draco_options(), trained}) {
    const fs::path reel = pack_as("reel", options);
    ASSERT_TRUE(cut(reel, "a", 0, 4));
    ASSERT_TRUE(cut(reel, "b", 5, 7));
    ASSERT_TRUE(cut(reel, "c", 8, 19));
    const auto joined = join({"a", "b", "c"}, "joined");
    ASSERT_TRUE(joined) << joined.error().message;
    EXPECT_EQ(joined->frames, kFrames);
    EXPECT_EQ(frames_of(at("joined")), frames_of(reel));
    EXPECT_EQ(read_manifest(at("joined"))->duration_us, read_manifest(reel)->duration_us);
    EXPECT_THAT(faults_of(at("joined")), IsEmpty());
    for (const char* name : {"reel", "a", "b", "c", "joined"}) fs::remove_all(at(name));
  }
}

TEST_F(Edit, times_choose_the_frames_that_are_shown) {
  PackOptions packed = options();
  packed.fps = 10.0;  // segments begin every 0.3 s
  const fs::path reel = pack_as("reel", packed);
  const auto frames = [&](std::uint64_t from_ms, std::uint64_t to_ms) {
    const auto report = cut_package({.input = reel,
                                     .output = at("cut"),
                                     .frames = {},
                                     .from_us = 1000 * from_ms,
                                     .to_us = 1000 * to_ms,
                                     .force = true});
    EXPECT_TRUE(report) << report.error().message;
    return report ? std::pair(report->frames.first, report->frames.last) : std::pair(99u, 99u);
  };
  EXPECT_EQ(frames(0, 10'000), std::pair(0u, 19u));
  EXPECT_EQ(frames(0, 1), std::pair(0u, 0u));
  EXPECT_EQ(frames(0, 300), std::pair(0u, 2u));
  EXPECT_EQ(frames(0, 301), std::pair(0u, 3u));
  EXPECT_EQ(frames(299, 300), std::pair(2u, 2u));
  EXPECT_EQ(frames(300, 301), std::pair(3u, 3u));
  EXPECT_EQ(frames(1'999, 9'999), std::pair(19u, 19u));
  EXPECT_EQ(read_manifest(at("cut")).value().duration_us, 1'000u);
  // The first and the last frame are shown only as long as they were between these times.
  EXPECT_EQ(frames(250, 610), std::pair(2u, 6u));
  const Manifest kept = read_manifest(at("cut")).value();
  EXPECT_EQ(kept.duration_us, 360'000u);
  EXPECT_EQ(kept.segments[1].times_us[0], 50'000u);
}

TEST_F(Edit, a_part_that_is_not_there_is_refused_and_nothing_is_written) {
  const fs::path reel = pack_as("reel", options());
  const auto refused = cut(reel, "cut", 3, 20);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::argument);
  EXPECT_EQ(refused.error().message, reel.string() + ": has no frame 20, only frames 0 to 19");
  const auto late = cut_package(
      {.input = reel, .output = at("cut"), .frames = {}, .from_us = 1'000'000, .to_us = 2'000'000});
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().message, reel.string() + ": ends at 0.667 s, before --from 1");
  EXPECT_FALSE(fs::exists(at("cut")));
  fs::create_directory(at("cut"));
  write_file(at("cut") / "mine", "mine");
  EXPECT_THAT(cut(reel, "cut", 0, 1).error().message, HasSubstr("cut"));
  EXPECT_EQ(contents(at("cut")).size(), 1u);
}

TEST_F(Edit, frame_rates_that_times_of_recordings_gave_need_not_be_equal) {
  PackOptions jitters = layered_options();
  jitters.fps = 30.0219;
  pack_as("first", layered_options());
  pack_as("second", jitters);
  const auto joined = join({"first", "second"}, "joined");
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_EQ(read_manifest(at("joined"))->fps, 30.0);
}

TEST_F(Edit, packages_that_do_not_go_together_are_refused_in_one_line) {
  const fs::path reel = pack_as("reel", layered_options());
  const std::string before = at("other").string() + ": cannot follow " + reel.string() + ": ";
  const auto refusal = [&](const PackOptions& other) {
    pack_as("other", other);
    const std::string line = error(join({"reel", "other"}, "joined"));
    fs::remove_all(at("other"));
    EXPECT_EQ(line.substr(0, before.size()), before) << line;
    return line.substr(std::min(before.size(), line.size()));
  };
  EXPECT_EQ(refusal(draco_options()),
            "the two reels have different codecs, octree and draco (set with pack --codec)");
  PackOptions other = layered_options();
  other.fps = 25.0;
  EXPECT_EQ(refusal(other),
            "the two reels have different frame rates, 30 and 25 (pack --fps sets the rate, and "
            "spaces frames evenly)");
  other = layered_options();
  other.encode.codec = OctreeOptions{Entropy::zstd, DepthRule::fixed(10)};
  EXPECT_EQ(
      refusal(other),
      "the two reels have different entropy coders, context and zstd (set with pack --entropy)");
  other = layered_options();
  std::get<OctreeOptions>(other.encode.codec).depth = DepthRule::fixed(8);
  EXPECT_EQ(refusal(other), "the two reels have different layers");
  other = layered_options();
  other.up = 'z';
  EXPECT_EQ(refusal(other), "the two reels have different up axes, y and z (set with pack --up)");
  other = layered_options();
  other.encode.colors = false;
  EXPECT_EQ(refusal(other), "only the first of the two reels has colours");
  other = layered_options();
  other.train = true;
  EXPECT_EQ(refusal(other), "the two reels have different context tables");
  EXPECT_FALSE(fs::exists(at("joined")));
}

TEST_F(Edit, a_part_of_a_damaged_file_does_not_look_good_afterwards) {
  const fs::path reel = pack_as("reel", options());
  const LayerFile file = read_manifest(reel).value().segments[2].layers[0];
  std::string bytes = read_file(reel / file.path);
  bytes.back() = static_cast<char>(bytes.back() + 1);
  fs::remove(reel / file.path);
  write_file(reel / file.path, bytes);
  const std::uint32_t first = read_manifest(reel).value().segments[2].first_frame;
  const auto part = cut(reel, "part", first, first);
  ASSERT_FALSE(part);
  EXPECT_THAT(part.error().message, HasSubstr((reel / file.path).string() + ": has the checksum"));
  EXPECT_FALSE(fs::exists(at("part")));
}

TEST_F(Edit, files_of_another_size_and_damaged_manifests_are_refused) {
  const fs::path reel = pack_as("reel", options());
  const std::string path = read_manifest(reel).value().segments[2].layers[0].path;
  fs::copy(reel, at("copy"));
  write_file(at("copy") / path, "short");
  const std::string line = error(join({"reel", "copy"}, "joined"));
  EXPECT_THAT(line, HasSubstr((at("copy") / path).string() + ": has 5 bytes, the manifest says"));
  EXPECT_TRUE(cut(at("copy"), "cut", 0, 5)) << "what is damaged is not needed";
  EXPECT_FALSE(cut(at("copy"), "cut2", 0, 6));
  fs::remove(at("copy") / path);
  EXPECT_FALSE(cut(at("copy"), "cut2", 0, 6));
  write_file(at("copy") / "reel.json", "{");
  EXPECT_THAT(error(join({"reel", "copy"}, "joined")), HasSubstr("reel.json: "));
  EXPECT_FALSE(fs::exists(at("joined")));
  EXPECT_FALSE(fs::exists(at("cut2")));
}

TEST_F(Edit, symbolic_links_are_followed) {
  const fs::path reel = pack_as("reel", options());
  fs::create_directory(at("links"));
  for (const auto& entry : fs::directory_iterator(reel))
    fs::create_symlink("../reel" / entry.path().filename(), at("links") / entry.path().filename());
  fs::create_directory(at("deep"));
  ASSERT_TRUE(cut(at("links"), "deep/cut", 0, 4));
  EXPECT_THAT(faults_of(at("deep/cut")), IsEmpty());
}

TEST_F(Edit, a_joined_package_may_replace_one_of_its_parts) {
  pack_as("a", options());
  EXPECT_FALSE(join({"a", "a"}, "a"));
  ASSERT_TRUE(join({"a", "a"}, "a", true));
  EXPECT_EQ(read_manifest(at("a")).value().frame_count(), 2u * kFrames);
  EXPECT_THAT(faults_of(at("a")), IsEmpty());
}

TEST_F(Edit, what_was_cleaned_is_shared_out_and_added_up_again) {
  const fs::path reel = pack_as("reel", options());
  Manifest manifest = read_manifest(reel).value();
  manifest.cleaning = Cleaning{20, 1000, 0.5, 0.1, 1.0};
  manifest.coding_error = CodingError{1, 4.0, 1.0, 9.0};
  write_file(reel / "reel.json", write_manifest(manifest));
  ASSERT_TRUE(cut(reel, "a", 0, 5));
  ASSERT_TRUE(cut(reel, "b", 6, 19));
  EXPECT_EQ(read_manifest(at("a"))->cleaning, (Cleaning{6, 300, 0.5, 0.1, 1.0}));
  ASSERT_TRUE(join({"a", "b"}, "joined"));
  EXPECT_EQ(read_manifest(at("joined"))->cleaning, manifest.cleaning);
  EXPECT_FALSE(read_manifest(at("joined"))->coding_error) << "nobody compared these frames";
  ASSERT_TRUE(cut(reel, "all", 0, 19));
  EXPECT_EQ(read_manifest(at("all"))->coding_error, manifest.coding_error);
}

TEST_F(Edit, a_manifest_that_would_be_too_long_is_refused) {
  const fs::path reel = pack_as("reel", options());
  Manifest manifest = read_manifest(reel).value();
  // Frames of one byte each, in files that are there.
  const std::uint32_t count = 600'000;
  manifest.segments.resize(1);
  manifest.segments[0].times_us.assign(count, 0);
  manifest.segments[0].points.assign(count, 1);
  for (LayerFile& file : manifest.segments[0].layers) {
    const std::uint32_t bytes = &file == &manifest.segments[0].layers[0] ? 1 : 0;
    file.frames.assign(count, Chunks<std::uint32_t>{bytes, 0, 0});
    file.bytes = std::uint64_t{bytes} * count;
    write_file(reel / file.path, std::string(file.bytes, ' '));
  }
  write_file(reel / "reel.json", write_manifest(manifest));
  const std::string line = error(join({"reel", "reel", "reel"}, "joined"));
  EXPECT_THAT(line, HasSubstr("joined: reel.json would have"));
  EXPECT_THAT(line, HasSubstr("make packages of fewer frames"));
  EXPECT_FALSE(fs::exists(at("joined")));
}

/// With 2 seconds of sound.
class EditSound : public Edit {
 protected:
  void SetUp() override {
    if (!is_installed("ffmpeg")) GTEST_SKIP() << "ffmpeg is not installed";
    Edit::SetUp();
    write_sound("sound.wav", 96'000);
    PackOptions packed = options();
    packed.fps = 10.0;
    packed.audio = at("sound.wav");
    pack_as("reel", packed);
    packed.audio.reset();
    pack_as("silent", packed);
  }
};

TEST_F(EditSound, is_cut_to_the_sample) {
  const std::vector<StereoSample> whole = sound_of(at("reel"));
  ASSERT_EQ(whole.size(), 96'000u);
  for (const auto& [first, last] : {std::pair(0u, 19u), {0, 4}, {3, 5}, {7, 13}, {18, 19}}) {
    const auto report = cut(at("reel"), "cut", first, last);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_THAT(faults_of(at("cut")), IsEmpty());
    const std::size_t from = report->frames.first * 4'800, to = (report->frames.last + 1) * 4'800;
    const std::vector<StereoSample> sound = sound_of(at("cut"));
    ASSERT_EQ(sound.size(), to - from);
    EXPECT_LT(difference(whole, from, sound, 0, sound.size()), 1e-3) << first;
    fs::remove_all(at("cut"));
  }
}

TEST_F(EditSound, has_the_length_that_is_stated_wherever_pieces_end) {
  CutOptions first{.input = at("reel"), .output = at("first")};
  first.from_us = 112'200;
  first.to_us = 478'700;
  ASSERT_TRUE(cut_package(first));
  for (std::uint64_t i = 0; i < 60; ++i) {
    CutOptions last{.input = at("reel"), .output = at("last")};
    last.from_us = 501'300 + 10'130 * i;
    last.to_us = last.from_us + 2'000 + 9'370 * i % 29'000;
    ASSERT_TRUE(cut_package(last)) << i;
    ASSERT_TRUE(join({"first", "last"}, "joined"));
    EXPECT_THAT(faults_of(at("joined")), IsEmpty()) << i;
    fs::remove_all(at("last"));
    fs::remove_all(at("joined"));
  }
}

TEST_F(EditSound, is_the_same_after_its_pieces_are_joined) {
  ASSERT_TRUE(cut(at("reel"), "a", 0, 5));
  ASSERT_TRUE(cut(at("reel"), "b", 6, 8));
  ASSERT_TRUE(cut(at("reel"), "c", 9, 19));
  const auto joined = join({"a", "b", "c"}, "joined");
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_THAT(joined->silent, IsEmpty());
  EXPECT_THAT(faults_of(at("joined")), IsEmpty());
  const std::vector<StereoSample> whole = sound_of(at("reel")), again = sound_of(at("joined"));
  ASSERT_EQ(again.size(), whole.size());
  EXPECT_EQ(difference(whole, 0, again, 0, whole.size()), 0.0) << "not one packet is lost";
}

TEST_F(EditSound, is_silent_where_a_package_has_none) {
  const auto joined = join({"silent", "reel", "silent", "reel"}, "joined");
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_THAT(joined->silent, ElementsAre(0u, 2u));
  EXPECT_THAT(faults_of(at("joined")), IsEmpty());
  const std::vector<StereoSample> whole = sound_of(at("reel")), sound = sound_of(at("joined"));
  ASSERT_NEAR(static_cast<double>(sound.size()), 4.0 * 96'000, 60.0);
  const auto loudest = [&](std::size_t from, std::size_t to) {
    float most = 0.0f;
    for (std::size_t i = from; i < to; ++i) most = std::max(most, std::abs(sound[i].left));
    return most;
  };
  EXPECT_LT(loudest(0, 95'000), 1e-3f);
  EXPECT_LT(loudest(2 * 96'000 + 2'000, 3 * 96'000 - 1'000), 1e-3f);
  // At its place within 1.25 ms, by a sweep of which no two parts are alike.
  for (const std::size_t place : {96'000u, 3u * 96'000u}) {
    double least = 1.0;
    std::size_t best = 0;
    for (std::size_t shift = 0; shift <= 1000; shift += 4) {
      const double error = difference(whole, 10'000, sound, place + 10'000 + shift - 500, 4'000);
      if (error < least) {
        least = error;
        best = shift;
      }
    }
    EXPECT_LT(least, 0.1);
    EXPECT_NEAR(static_cast<double>(best), 500.0, 62.0);
  }
}

TEST_F(EditSound, that_is_damaged_or_of_another_kind_is_refused) {
  const Manifest manifest = read_manifest(at("reel")).value();
  fs::copy(at("reel"), at("copy"));
  const fs::path file = at("copy") / manifest.audio->path;
  std::string bytes = read_text(file);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x55);
  write_file(file, bytes);
  const auto damaged = cut(at("copy"), "cut", 0, 19);
  ASSERT_FALSE(damaged);
  EXPECT_THAT(damaged.error().message,
              HasSubstr("is damaged; replace or remove it with pointreel-server audio"));
  write_file(file, std::string(bytes.size(), 'x'));
  EXPECT_THAT(cut(at("copy"), "cut", 0, 19).error().message, HasSubstr("is not Opus in Ogg"));
  EXPECT_FALSE(fs::exists(at("cut")));
}

TEST_F(EditSound, that_would_be_silent_for_years_is_refused_at_once) {
  Manifest manifest = read_manifest(at("silent")).value();
  manifest.duration_us = std::uint64_t{1} << 52;
  write_file(at("silent") / "reel.json", write_manifest(manifest));
  EXPECT_THAT(error(join({"silent", "reel"}, "joined")), HasSubstr("the sound would take more"));
  EXPECT_THAT(error(join({"silent", "silent", "reel"}, "joined")), HasSubstr("no time is left"));
}

TEST_F(RecorderTest, a_recording_is_cut_while_it_grows_and_joined_with_the_next) {
  constexpr std::uint8_t kSilence[]{0xfc, 0xff, 0xfe};
  LiveRecorder recorder(options());
  recorder.hello(real_hello(1));
  give_frames(recorder, 0, 23);
  ASSERT_TRUE(read_manifest(package())->live);
  const fs::path out = temporary_ / "out";
  const auto growing = cut_package({.input = package(), .output = out / "growing"});
  ASSERT_TRUE(growing) << growing.error().message;
  EXPECT_EQ(growing->frames.last, 19u);
  EXPECT_EQ(read_manifest(out / "growing")->captured_us, kStart);
  ASSERT_TRUE(
      cut_package({.input = package(), .output = out / "later", .frames = CutRange{7, 12}}));
  EXPECT_EQ(read_manifest(out / "later")->captured_us, kStart + 7 * kPeriod);
  EXPECT_FALSE(read_manifest(out / "growing")->live);
  recorder.end();
  recorder.hello(real_hello(2));
  for (std::uint32_t i = 0; i < 20; ++i) {
    const auto bytes =
        std::make_shared<const Bytes>(write_live_sound({i, kStart + 20'000 * i, 960, kSilence}));
    recorder.sound(parse_live_sound(*bytes).value(), {LiveMessage::Kind::binary, bytes});
  }
  give_frames(recorder, 0, 10);
  recorder.end();
  const auto joined = join_packages(
      {.inputs = {package(), package("stage-2")}, .output = out / "joined", .force = false});
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_EQ(joined->frames, 33u);
  EXPECT_EQ(read_manifest(out / "joined")->captured_us, kStart);
  EXPECT_THAT(joined->silent, ElementsAre(0u));
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(out / "joined", frames), IsEmpty());
  std::vector<std::string> segments = segments_of(package());
  for (std::string& more : segments_of(package("stage-2"))) segments.push_back(std::move(more));
  EXPECT_EQ(segments_of(out / "joined"), segments);
  const Manifest manifest = read_manifest(out / "joined").value();
  EXPECT_EQ(frame_time_us(manifest, 23), 23 * kPeriod);
  EXPECT_EQ(manifest.duration_us, 33 * kPeriod);
  EXPECT_NEAR(static_cast<double>(manifest.audio->samples), 48.0 * (920 + 400), 60.0);
}

}  // namespace
}  // namespace pointreel::edit_test
