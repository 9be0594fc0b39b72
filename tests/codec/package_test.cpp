#include "pointreel/package.h"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/package/manifest.h"
#include "tests/temporary_folder.h"

namespace pointreel::package_test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// Two segments with two frames and one frame, and two layers. The last frame has only a base,
/// without points.
Manifest example() {
  Manifest m;
  m.name = "läufer 1";
  m.codec = "octree";
  m.entropy = "zstd";
  m.fps = 29.97;
  m.duration_us = 100100;
  m.up = 'z';
  m.colors = true;
  m.depth_min = 0;
  m.depth_max = 10;
  m.bounds.grow(glm::dvec3(1e6 + 0.1, -2, 3));
  m.bounds.grow(glm::dvec3(1e6 + 0.7, 1.0 / 3.0, 4));
  m.layer_names = {"base", "full"};
  Segment first;
  first.cube = {{1e6 + 0.1, -2, 3}, 7.0 / 3.0};
  first.times_us = {0, 33366};
  first.points = {1000, 1001};
  first.layers = {{{"00000.base.prs", 150, 0x0123456789abcdefu}, {{40, 30, 0}, {50, 30, 0}}},
                  {{"00000.full.prs", 500, 0xfedcba9876543210u}, {{200, 0, 0}, {200, 100, 0}}}};
  Segment second;
  second.first_frame = 2;
  second.times_us = {66733};
  second.points = {0};
  second.layers = {{{"00002.base.prs", 24, 1}, {{24, 0, 0}}},
                   {{"00002.full.prs", 0, 2}, {{0, 0, 0}}}};
  m.segments = {first, second};
  return m;
}

std::string error_of(const std::string& text) {
  const Result<Manifest> manifest = parse_manifest(text);
  return manifest ? "accepted" : manifest.error().message;
}

/// The error of the example after `patch` is applied (RFC 7396, arrays as a whole).
std::string error_with(const json& patch) {
  json root = json::parse(write_manifest(example()));
  root.merge_patch(patch);
  return error_of(root.dump());
}

/// The error of the example after the value at `pointer` is replaced.
std::string error_at(const std::string& pointer, const json& value) {
  json root = json::parse(write_manifest(example()));
  root.at(json::json_pointer(pointer)) = value;
  return error_of(root.dump());
}

TEST(Manifest, names_tables_only_if_frames_can_use_them) {
  Manifest m = example();
  m.entropy = "context";
  m.tables = PackageFile{"tables.01234567.prs", 1000, 0x0123456789abcdefu};
  const Result<Manifest> back = parse_manifest(write_manifest(m));
  ASSERT_TRUE(back) << back.error().message;
  ASSERT_TRUE(back->tables);
  EXPECT_EQ(back->tables->path, m.tables->path);
  EXPECT_EQ(back->tables->bytes, 1000u);
  EXPECT_EQ(back->tables->checksum, m.tables->checksum);
  ASSERT_EQ(back->files().size(), 5u);
  EXPECT_EQ(back->files().front()->path, m.tables->path);
  EXPECT_EQ(write_manifest(*back), write_manifest(m));

  m.tables->bytes = kMaxTablesBytes + 1;
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("tables: bytes"));
  m.tables = PackageFile{"../tables", 1, 1};
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("tables: path"));
  m.tables->path = m.segments[0].layers[0].path;
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("used twice"));
  EXPECT_THAT(error_with({{"tables", {{"path", "a"}, {"bytes", 1}, {"xxh3", "0123456789abcdef"}}}}),
              HasSubstr("belong to entropy"));
}

TEST(Manifest, states_the_groups_of_video_and_of_nothing_else) {
  const json video = {{"codec", "video"}, {"group_frames", 16}};
  EXPECT_EQ(error_with(video), "accepted");
  json root = json::parse(write_manifest(example()));
  root.merge_patch(video);
  const Manifest manifest = parse_manifest(root.dump()).value();
  EXPECT_EQ(manifest.group_frames, 16u);
  EXPECT_EQ(json::parse(write_manifest(manifest))["group_frames"], 16);
  EXPECT_THAT(error_with({{"codec", "video"}}), HasSubstr("group_frames"));
  EXPECT_THAT(error_with({{"codec", "video"}, {"group_frames", 65}}), HasSubstr("group_frames"));
  EXPECT_THAT(error_with({{"group_frames", 16}}), HasSubstr("only video has groups"));
  const json scalars = {{{"name", "heat"}, {"min", 0}, {"max", 1}, {"labels", false}}};
  EXPECT_THAT(error_with({{"codec", "video"}, {"group_frames", 16}, {"scalars", scalars}}),
              HasSubstr("scalars: video has none"));
}

TEST(Manifest, names_a_file_of_sound) {
  Manifest m = example();
  m.audio = AudioFile{{"audio.01234567.opus", 1000, 0x0123456789abcdefu}, 96'000};
  const Result<Manifest> back = parse_manifest(write_manifest(m));
  ASSERT_TRUE(back) << back.error().message;
  ASSERT_TRUE(back->audio);
  EXPECT_EQ(back->audio->path, m.audio->path);
  EXPECT_EQ(back->audio->samples, 96'000u);
  EXPECT_EQ(back->files().front()->path, m.audio->path);
  EXPECT_EQ(write_manifest(*back), write_manifest(m));

  m.audio->bytes = kMaxAudioBytes + 1;
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("audio: bytes"));
  m.audio->bytes = 1000;
  m.audio->samples = 0;
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("audio: samples"));
  m.audio->samples = 1;
  m.audio->path = "../audio";
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("audio: path"));
  m.audio->path = m.segments[0].layers[0].path;
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("used twice"));
  const json no_samples = {{"path", "a"}, {"bytes", 1}, {"xxh3", "0123456789abcdef"}};
  EXPECT_THAT(error_with({{"audio", no_samples}}), HasSubstr("audio: samples"));
  EXPECT_THAT(error_with({{"audio", "a"}}), HasSubstr("audio"));
}

TEST(Manifest, tells_how_frames_were_cleaned) {
  Manifest m = example();
  m.cleaning = Cleaning{3, 12, 0.5, 0.25, 1e-3};
  const auto back = parse_manifest(write_manifest(m));
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->cleaning, m.cleaning);
  const json good = {
      {"frames", 3}, {"removed_points", 12}, {"spacing", 0.5}, {"noise", 0.25}, {"radius", 1e-3}};
  for (const auto& [key, value] : good.items()) {
    json bad = good;
    bad[key] = -1;
    EXPECT_THAT(error_with({{"cleaning", bad}}), HasSubstr("cleaning: " + key));
    bad.erase(key);
    EXPECT_THAT(error_with({{"cleaning", bad}}), HasSubstr("cleaning: " + key));
  }
  EXPECT_THAT(error_with({{"cleaning", 5}}), HasSubstr("cleaning"));
}

TEST(Manifest, tells_what_coding_lost) {
  Manifest m = example();
  for (const CodingError& error : {CodingError{2, 0.25, 0.125, 9.5}, CodingError{1, 0.0, {}, {}}}) {
    m.coding_error = error;
    EXPECT_EQ(parse_manifest(write_manifest(m)).value().coding_error, error);
  }
  EXPECT_THAT(error_with({{"coding_error", {{"frames", 0}, {"d1", 1}}}}),
              HasSubstr("frames: is 0"));
  EXPECT_THAT(error_with({{"coding_error", {{"frames", 1u << 31}, {"d1", 1}}}}),
              HasSubstr("frames: are more than the reel has"));
  EXPECT_THAT(error_with({{"coding_error", {{"frames", 1}, {"d1", -1}}}}),
              HasSubstr("coding_error: d1"));
  EXPECT_THAT(error_with({{"coding_error", {{"frames", 1}}}}), HasSubstr("coding_error: d1"));
  EXPECT_THAT(error_with({{"coding_error", {{"frames", 1}, {"d1", 1}, {"luma", -1}}}}),
              HasSubstr("coding_error: luma"));
}

TEST(Manifest, tells_when_it_was_captured) {
  Manifest m = example();
  m.captured_us = 1'781'280'005'250'000;
  EXPECT_EQ(parse_manifest(write_manifest(m))->captured_us, m.captured_us);
  EXPECT_FALSE(parse_manifest(write_manifest(example()))->captured_us);
  for (const json& wrong : {json(-1), json(0.5), json("2026"), json(9007199254740992)})
    EXPECT_THAT(error_with({{"captured_us", wrong}}), HasSubstr("captured_us")) << wrong;
}

TEST(Manifest, says_whether_normals_were_estimated) {
  for (const bool estimated : {false, true}) {
    Manifest m = example();
    m.normals_estimated = estimated;
    EXPECT_EQ(parse_manifest(write_manifest(m))->normals_estimated, estimated);
  }
  EXPECT_THAT(error_with({{"normals_estimated", 1}}), HasSubstr("normals_estimated"));
}

TEST(Manifest, points_up_along_any_axis) {
  Manifest m = example();
  for (const char* name : {"x", "-x", "y", "-y", "z", "-z"}) {
    m.up = *parse_up(name);
    const Result<Manifest> back = parse_manifest(write_manifest(m));
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->up.text(), name);
  }
}

TEST(Manifest, is_parsed_as_it_was_written) {
  const Manifest m = example();
  const Result<Manifest> back = parse_manifest(write_manifest(m));
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->name, m.name);
  EXPECT_EQ(back->codec, "octree");
  EXPECT_EQ(back->entropy, "zstd");
  EXPECT_EQ(back->fps, m.fps);
  EXPECT_EQ(back->duration_us, m.duration_us);
  EXPECT_EQ(back->up, 'z');
  EXPECT_TRUE(back->colors);
  EXPECT_FALSE(back->normals);
  EXPECT_EQ(back->depth_min, 0u);
  EXPECT_EQ(back->depth_max, 10u);
  EXPECT_EQ(back->bounds, m.bounds) << "doubles must be exact";
  EXPECT_EQ(back->layer_names, m.layer_names);
  ASSERT_EQ(back->segments.size(), 2u);
  for (std::size_t s = 0; s < 2; ++s) {
    EXPECT_EQ(back->segments[s].first_frame, m.segments[s].first_frame);
    EXPECT_EQ(back->segments[s].cube, m.segments[s].cube);
    EXPECT_EQ(back->segments[s].times_us, m.segments[s].times_us);
    EXPECT_EQ(back->segments[s].points, m.segments[s].points);
    ASSERT_EQ(back->segments[s].layers.size(), 2u);
    for (std::size_t l = 0; l < 2; ++l) {
      EXPECT_EQ(back->segments[s].layers[l].path, m.segments[s].layers[l].path);
      EXPECT_EQ(back->segments[s].layers[l].bytes, m.segments[s].layers[l].bytes);
      EXPECT_EQ(back->segments[s].layers[l].checksum, m.segments[s].layers[l].checksum);
      EXPECT_EQ(back->segments[s].layers[l].frames, m.segments[s].layers[l].frames);
    }
  }
  EXPECT_EQ(write_manifest(*back), write_manifest(m));
}

TEST(Manifest, is_parsed_for_a_draco_reel_without_frames) {
  Manifest m;
  m.codec = "draco";
  m.layer_names = {"full"};
  const Result<Manifest> back = parse_manifest(write_manifest(m));
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->frame_count(), 0u);
  EXPECT_TRUE(back->bounds.empty());
  EXPECT_EQ(back->entropy, "");
}

TEST(Manifest, is_valid_json_even_if_the_name_is_not_utf_8) {
  Manifest m = example();
  m.name =
      "a\xff"
      "b";
  EXPECT_TRUE(parse_manifest(write_manifest(m)));
}

TEST(Manifest, locates_frames_and_their_bytes) {
  const Manifest m = example();
  EXPECT_EQ(m.frame_count(), 3u);
  EXPECT_EQ(locate(m, 1).segment, 0u);
  EXPECT_EQ(locate(m, 1).index, 1u);
  EXPECT_EQ(locate(m, 2).segment, 1u);
  EXPECT_EQ(locate(m, 2).index, 0u);
  EXPECT_EQ(byte_range(m.segments[0].layers[1], 1).offset, 200u);
  EXPECT_EQ(byte_range(m.segments[0].layers[1], 1).size, 300u);
}

TEST(Manifest, groups_of_frames_end_with_their_segment) {
  Manifest m = example();
  const auto expect_group = [&](std::uint32_t frame, std::uint32_t first, std::uint32_t frames) {
    const FrameGroup group = group_of(m, frame);
    EXPECT_EQ(group.first, first) << frame;
    EXPECT_EQ(group.frames, frames) << frame;
  };
  expect_group(1, 1, 1);
  m.group_frames = 2;
  expect_group(1, 0, 2);
  expect_group(2, 2, 1);
  m.group_frames = 24;
  expect_group(1, 0, 2);
}

TEST(Manifest, finds_the_last_frame_that_has_begun) {
  const Manifest m = example();
  EXPECT_EQ(frame_time_us(m, 2), 66733u);
  EXPECT_EQ(frame_at(m, 0), 0u);
  EXPECT_EQ(frame_at(m, 33365), 0u);
  EXPECT_EQ(frame_at(m, 33366), 1u);
  EXPECT_EQ(frame_at(m, 66732), 1u);
  EXPECT_EQ(frame_at(m, 66733), 2u);
  EXPECT_EQ(frame_at(m, ~std::uint64_t{0}), 2u);
  Manifest late = m;
  late.segments[0].times_us = {10, 20};
  EXPECT_EQ(frame_at(late, 5), 0u) << "clamped to the reel";
}

TEST(Manifest, knows_which_frames_of_video_are_shown) {
  Manifest m = example();
  m.segments[0].times_us = {0, 0};
  EXPECT_EQ(shown_frames(m).size(), m.frame_count()) << "all that stand alone";
  m.group_frames = 2;
  EXPECT_EQ(shown_frames(m), (std::vector<std::uint32_t>{1, 2}));
}

TEST(Manifest, ignores_unknown_keys) {
  EXPECT_EQ(error_with({{"comment", {{"by", "somebody"}}}}), "accepted");
}

TEST(Manifest, refuses_a_newer_version_and_names_its_number) {
  EXPECT_THAT(error_with({{"version", 2}, {"segments", "in another form"}}),
              HasSubstr("version 2 is newer than 1"));
  EXPECT_THAT(error_with({{"version", 0}}), HasSubstr("version 0 does not exist"));
  EXPECT_THAT(error_with({{"format", "other"}}), HasSubstr("format"));
}

TEST(Manifest, names_every_missing_key) {
  const json whole = json::parse(write_manifest(example()));
  for (const auto& [key, value] : whole.items()) {
    json root = whole;
    root.erase(key);
    EXPECT_THAT(error_of(root.dump()), HasSubstr(key)) << key;
  }
  for (const char* place : {"/segments/1", "/segments/1/cube", "/segments/1/files/0", "/bounds"}) {
    for (const auto& [key, value] : whole.at(json::json_pointer(place)).items()) {
      json root = whole;
      root.at(json::json_pointer(place)).erase(key);
      EXPECT_THAT(error_of(root.dump()), HasSubstr(key + ": is missing")) << place;
    }
  }
}

TEST(Manifest, refuses_every_value_of_another_type) {
  const json flat = json::parse(write_manifest(example())).flatten();
  for (const auto& [pointer, value] : flat.items()) {
    for (const json& wrong : {json("?"), json::object(), json::array({json::array()}), json(true),
                              json(-1), json(1e300), json(0.5)}) {
      // A field that may hold any number, text or boolean accepts another value of its type.
      const bool same = wrong.type() == value.type() || (wrong.is_number() && value.is_number());
      if (same && (value.is_number_float() || value.is_string() || value.is_boolean())) continue;
      if (same && (pointer.find("origin") != std::string::npos ||
                   pointer.find("bounds") != std::string::npos || pointer == "/fps")) {
        continue;
      }
      EXPECT_NE(error_at(pointer, wrong), "accepted") << pointer << " = " << wrong;
    }
  }
}

TEST(Manifest, refuses_counts_that_are_negative_fractional_or_too_large) {
  for (const json& wrong : {json(4294967296), json(-1), json(1.0), json(1e9)}) {
    EXPECT_THAT(error_at("/segments/0/points/1", wrong), HasSubstr("segments[0]: points[1]"));
    EXPECT_THAT(error_at("/segments/0/files/1/frames/1/0", wrong),
                HasSubstr("segments[0]: files[1]: frames[1]"));
    EXPECT_THAT(error_at("/segments/1/first_frame", wrong), HasSubstr("first_frame"));
    EXPECT_THAT(error_at("/depth_max", wrong), HasSubstr("depth_max"));
  }
  EXPECT_THAT(error_at("/depth_max", 22), HasSubstr("depth_max"));
  EXPECT_THAT(error_at("/depth_min", 11), HasSubstr("depth_min"));
  EXPECT_THAT(error_at("/duration_us", 9007199254740992), HasSubstr("duration_us"));
  EXPECT_THAT(error_at("/segments/0/files/0/bytes", 18446744073709551615u), HasSubstr("bytes"));
}

TEST(Manifest, refuses_numbers_that_are_not_finite) {
  std::string text = write_manifest(example());
  text.replace(text.find("29.97"), 5, "1e999");
  EXPECT_NE(error_of(text), "accepted");
  text = write_manifest(example());
  text.replace(text.find("29.97"), 5, "NaN");
  EXPECT_EQ(error_of(text), "is not valid JSON");
  Manifest m = example();
  m.segments[0].cube.edge = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(error_of(write_manifest(m)), "accepted");
  EXPECT_THAT(error_at("/segments/0/cube/edge", 0.0), HasSubstr("segments[0]: cube: edge"));
  EXPECT_THAT(error_at("/segments/0/cube/edge", -1.0), HasSubstr("cube: edge"));
  EXPECT_THAT(error_at("/fps", 0), HasSubstr("fps"));
  EXPECT_THAT(error_at("/fps", -30), HasSubstr("fps"));
}

TEST(Manifest, refuses_a_cube_whose_far_corner_is_not_finite) {
  Manifest m = example();
  m.segments[0].cube = {glm::dvec3(1.7e308), 1e308};
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("cube"));
}

TEST(Manifest, refuses_every_path_that_could_leave_the_folder) {
  for (const char* path : {"../x.prs", "/etc/passwd", "a/b.prs", "a\\b.prs", "..", ".", "", ".prs",
                           "C:x.prs", "reel.json", "%2e%2e", "x y", "x\ny", "\xc3\xa4"}) {
    EXPECT_THAT(error_at("/segments/1/files/0/path", path), HasSubstr("path")) << path;
  }
  EXPECT_THAT(error_at("/segments/1/files/0/path", std::string("a\0b", 3)), HasSubstr("path"));
  EXPECT_THAT(error_at("/segments/1/files/0/path", std::string(300, 'a')), HasSubstr("path"));
  EXPECT_THAT(error_at("/segments/1/files/0/path", "00000.full.prs"), HasSubstr("used twice"));
}

TEST(Manifest, refuses_sizes_that_do_not_add_up) {
  EXPECT_THAT(error_at("/segments/0/files/0/bytes", 151), HasSubstr("take 150"));
  EXPECT_THAT(error_at("/segments/0/files/1/frames/0/1", 1), HasSubstr("take 501"));
}

TEST(Manifest, refuses_chunks_that_no_frame_can_have) {
  Manifest m = example();
  m.segments[1].layers[0] = {{"00002.base.prs", 0, 1}, {{0, 0, 0}}};
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("has no geometry"));
  m = example();
  m.segments[1].layers[1] = {{"00002.full.prs", 5, 1}, {{0, 5, 0}}};
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("segments[1]: files[1].frames[0]"));
  m = example();
  m.colors = false;
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("without colours"));
  m = example();
  m.segments[0].layers[1] = {{"00000.full.prs", 500, 1}, {{200, 0, 0}, {200, 0, 100}}};
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("without normals"));
}

TEST(Manifest, refuses_frames_that_are_not_consecutive_or_go_backward_in_time) {
  EXPECT_THAT(error_at("/segments/1/first_frame", 3), HasSubstr("2 comes next"));
  EXPECT_THAT(error_at("/segments/1/first_frame", 1000000000), HasSubstr("2 comes next"));
  EXPECT_THAT(error_at("/segments/1/times_us/0", 33365), HasSubstr("after 33366"));
  EXPECT_THAT(error_at("/segments/1/times_us", json::array()), HasSubstr("at least one frame"));
  EXPECT_THAT(error_at("/segments/0/times_us", {0, 1, 2}), HasSubstr("2 entries for 3 frames"));
  EXPECT_THAT(error_at("/duration_us", 66732), HasSubstr("duration_us"));
}

TEST(Manifest, refuses_layers_and_bounds_that_contradict_the_frames) {
  EXPECT_THAT(error_with({{"layers", {"base"}}}), HasSubstr("2 entries for 1 layers"));
  EXPECT_THAT(error_with({{"layers", {"base", "base"}}}), HasSubstr("comes twice"));
  EXPECT_THAT(error_with({{"layers", json::array()}}), HasSubstr("layers"));
  EXPECT_THAT(error_at("/bounds", nullptr), HasSubstr("bounds"));
  EXPECT_THAT(error_at("/bounds/min/2", 5), HasSubstr("min is beyond max"));
}

TEST(Manifest, refuses_control_characters_in_a_name) {
  EXPECT_THAT(error_with({{"name", "\x1b[2J"}}), HasSubstr("name"));
  EXPECT_THAT(error_with({{"name", std::string(256, 'a')}}), HasSubstr("name"));
}

TEST(Manifest, states_its_position_in_a_live_stream) {
  Manifest m = example();
  EXPECT_FALSE(parse_manifest(write_manifest(m)).value().live);
  m.live = LiveManifest{0xfedcba9876543210, 4'000'000'000, 1'700'000'000'000'000, true};
  const auto live = parse_manifest(write_manifest(m)).value().live;
  ASSERT_TRUE(live);
  EXPECT_EQ(live->session, 0xfedcba9876543210);
  EXPECT_EQ(live->first_frame, 4'000'000'000);
  EXPECT_EQ(live->start_us, 1'700'000'000'000'000u);
  EXPECT_TRUE(live->ended);
  const json good = {
      {"session", "0000000000000001"}, {"first_frame", 0}, {"start_us", 0}, {"ended", false}};
  EXPECT_EQ(error_with({{"live", good}}), "accepted");
  const json wrongs = {{"session", "1"}, {"first_frame", -1}, {"start_us", 0.5}, {"ended", 0}};
  for (const auto& [key, wrong] : wrongs.items()) {
    json bad = good;
    bad[key] = wrong;
    EXPECT_THAT(error_with({{"live", bad}}), HasSubstr("live: " + key));
  }
}

TEST(Manifest, names_the_sound_of_segments_in_live_streams_alone) {
  Manifest m = example();
  m.live = LiveManifest{};
  m.segments[1].sound = PackageFile{"1.sound.prs", 500, 0xfedcba9876543210};
  const Manifest read = parse_manifest(write_manifest(m)).value();
  EXPECT_FALSE(read.segments[0].sound);
  ASSERT_TRUE(read.segments[1].sound);
  EXPECT_EQ(read.segments[1].sound->path, "1.sound.prs");
  EXPECT_EQ(read.segments[1].sound->bytes, 500u);
  EXPECT_EQ(read.segments[1].sound->checksum, 0xfedcba9876543210);
  EXPECT_EQ(read.files().back()->path, "1.sound.prs");

  m.live.reset();
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("segments[1].sound: belongs to live streams"));
  m.live = LiveManifest{};
  m.segments[1].sound->bytes = kMaxSegmentSoundBytes + 1;
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("segments[1].sound"));
  m.segments[1].sound = m.segments[0].layers[0];
  EXPECT_THAT(error_of(write_manifest(m)), HasSubstr("used twice"));
}

TEST(Manifest, is_the_same_if_written_segment_by_segment) {
  const Manifest m = example();
  std::vector<std::string> lines;
  for (const Segment& segment : m.segments) lines.push_back(write_segment(segment));
  Manifest head = m;
  head.segments.clear();
  EXPECT_EQ(write_manifest(head, lines), write_manifest(m));
}

TEST(Manifest, refuses_duplicate_keys) {
  std::string text = write_manifest(example());
  text.replace(text.find("\"fps\""), 5, "\"up\"");
  EXPECT_THAT(error_of(text), HasSubstr("key twice"));
  text = write_manifest(example());
  text.replace(text.find("\"points\""), 8, "\"times_us\"");
  EXPECT_THAT(error_of(text), HasSubstr("key twice"));
}

TEST(Manifest, survives_deeply_nested_json) {
  EXPECT_EQ(error_of(std::string(10'000'000, '[')), "is nested too deep");
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
  EXPECT_EQ(error_of(objects), "is nested too deep");
  EXPECT_EQ(error_of(std::string(1000, '[') + std::string(1000, ']')), "is nested too deep");
  EXPECT_THAT(error_of(std::string(kMaxManifestBytes + 1, ' ')), HasSubstr("longer"));
}

TEST(Manifest, is_refused_if_truncated_at_any_byte) {
  const std::string text = write_manifest(example());
  for (std::size_t size = 0; size + 2 < text.size(); ++size) {
    ASSERT_NE(error_of(text.substr(0, size)), "accepted") << size;
  }
}

TEST(Manifest, is_read_from_a_folder_with_the_path_in_every_error) {
  const TemporaryFolder temporary;
  const std::filesystem::path& folder = temporary.path();
  EXPECT_THAT(read_manifest(folder).error().message, HasSubstr("is not a package"));
  EXPECT_THAT(read_manifest(folder).error().message, HasSubstr(folder.string() + ": "));
  temporary.write("reel.json", write_manifest(example()));
  EXPECT_TRUE(read_manifest(folder));
  temporary.write("reel.json", "{}");
  EXPECT_THAT(read_manifest(folder).error().message, HasSubstr("reel.json: format: is missing"));
}

TEST(Checksum, is_the_64_bit_xxh3) {
  EXPECT_EQ(checksum_of({}), 0x2d06800538d394c2u) << "the published value for empty input";
}

TEST(Manifest, lists_scalar_fields_with_their_ranges) {
  Manifest m = example();
  m.scalars = {{"intensity", -0.5, 4095, false}, {"class \"x\"", 2, 6, true}};
  const Result<Manifest> back = parse_manifest(write_manifest(m));
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->scalars, m.scalars);
  EXPECT_EQ(write_manifest(*back), write_manifest(m));
  m.scalars.clear();
  EXPECT_EQ(write_manifest(m).find("scalars"), std::string::npos);
  const auto error = [](const json& fields) { return error_with({{"scalars", fields}}); };
  const json good = {{"name", "a"}, {"min", 0}, {"max", 1}, {"labels", false}};
  EXPECT_EQ(error(json::array({good})), "accepted");
  EXPECT_THAT(error(json::array({good, good})), HasSubstr("comes twice"));
  EXPECT_THAT(error(json(std::vector<json>(9, good))), HasSubstr("more than 8"));
  const auto with = [&](const char* key, const json& value) {
    json field = good;
    field[key] = value;
    return error(json::array({field}));
  };
  EXPECT_THAT(with("name", ""), HasSubstr("scalars: a name"));
  EXPECT_THAT(with("name", "a\u202e"), HasSubstr("scalars: a name"));
  EXPECT_THAT(with("name", std::string(65, 'a')), HasSubstr("scalars: a name"));
  EXPECT_THAT(with("min", 2), HasSubstr("no finite range"));
  EXPECT_THAT(with("labels", 1), HasSubstr("scalars"));
  EXPECT_THAT(error(5), HasSubstr("scalars"));
}

}  // namespace
}  // namespace pointreel::package_test
