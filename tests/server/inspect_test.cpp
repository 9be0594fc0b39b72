#include "server/inspect/inspect.h"

#include <cmath>
#include <filesystem>
#include <random>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/distance/distance.h"
#include "codec/files/cloud_file.h"
#include "codec/package/manifest.h"
#include "tests/packed_clouds.h"

namespace pointreel::inspect_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

/// A package of 5 frames in two segments, with all three layers.
class Inspect : public testing::Test {
 protected:
  void SetUp() override {
    write_frames(folder() / "in", 5);
    PackOptions options = pack_options(folder() / "in", reel());
    options.segment_frames = 3;
    const Result<PackSummary> summary = pack(options);
    ASSERT_TRUE(summary) << summary.error().message;
  }

  fs::path folder() const { return folder_.path(); }
  fs::path reel() const { return folder() / "reel"; }
  Manifest manifest() const { return read_manifest(reel()).value(); }
  UnpackOptions unpacking() const { return {.input = reel(), .output = folder() / "out"}; }

  std::vector<Fault> faults() const {
    const Result<VerifyReport> report = verify(reel());
    if (!report) ADD_FAILURE() << report.error().message;
    return report ? report->faults : std::vector<Fault>{};
  }

  /// Returns the path of the layer file that begins with `beginning`. It ends in a checksum.
  std::string layer_file(const std::string& beginning) const {
    for (const Segment& segment : manifest().segments) {
      for (const LayerFile& file : segment.layers) {
        if (file.path.starts_with(beginning)) return file.path;
      }
    }
    ADD_FAILURE() << "no layer file " << beginning;
    return {};
  }

  void flip_byte(const std::string& file, std::uint64_t at) const {
    std::string content = read_text(reel() / file);
    content.at(at) = static_cast<char>(content.at(at) ^ 0x10);
    write_file(reel() / file, content);
  }

 private:
  TemporaryFolder folder_;
};

class Verify : public Inspect {};
class Unpack : public Inspect {};

TEST_F(Verify, finds_no_fault_in_a_packed_reel) {
  const Result<VerifyReport> report = verify(reel());
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_THAT(report->faults, IsEmpty());
  EXPECT_EQ(report->frames, 5u);
  EXPECT_EQ(report->files, 6u);
  std::uint64_t bytes = 0;
  for (const auto& [name, content] : contents(reel())) {
    if (name != "reel.json") bytes += content.size();
  }
  EXPECT_EQ(report->bytes, bytes);
}

TEST_F(Verify, names_the_file_and_frame_of_a_flipped_byte_anywhere) {
  const Manifest m = manifest();
  for (const Segment& segment : m.segments) {
    for (const LayerFile& file : segment.layers) {
      const ByteRange range = byte_range(file, 1);
      for (const std::uint64_t at :
           {range.offset, range.offset + range.size / 2, range.offset + range.size - 1}) {
        flip_byte(file.path, at);
        const std::vector<Fault> found = faults();
        flip_byte(file.path, at);
        ASSERT_EQ(found.size(), 2u) << file.path << " at " << at;
        EXPECT_EQ(found[0].file, file.path);
        EXPECT_FALSE(found[0].frame);
        EXPECT_THAT(found[0].what, HasSubstr("checksum"));
        EXPECT_EQ(found[1].file, file.path);
        EXPECT_EQ(found[1].frame, segment.first_frame + 1);
      }
    }
  }
  EXPECT_THAT(faults(), IsEmpty());
}

TEST_F(Verify, names_a_truncated_file_and_its_truncated_frame) {
  const std::string file = layer_file("00003.middle");
  fs::resize_file(reel() / file, fs::file_size(reel() / file) - 1);
  const std::vector<Fault> found = faults();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].file, file);
  EXPECT_THAT(found[0].what, HasSubstr("bytes"));
  EXPECT_EQ(found[1].file, file);
  EXPECT_EQ(found[1].frame, 4u);
}

TEST_F(Verify, names_a_file_that_is_too_long) {
  const std::string file = layer_file("00000.full");
  write_file(reel() / file, read_text(reel() / file) + "x");
  const std::vector<Fault> found = faults();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].file, file);
}

TEST_F(Verify, names_a_missing_file_and_every_frame_that_needs_it) {
  const std::string file = layer_file("00003.base");
  fs::remove(reel() / file);
  const std::vector<Fault> found = faults();
  ASSERT_EQ(found.size(), 3u);
  for (const Fault& fault : found) EXPECT_EQ(fault.file, file);
  EXPECT_EQ(found[1].frame, 3u);
  EXPECT_EQ(found[2].frame, 4u);
}

TEST_F(Verify, names_both_of_two_swapped_files) {
  const std::string first = layer_file("00000.base"), second = layer_file("00003.base");
  fs::rename(reel() / first, reel() / "x");
  fs::rename(reel() / second, reel() / first);
  fs::rename(reel() / "x", reel() / second);
  std::set<std::string> named;
  for (const Fault& fault : faults()) named.insert(fault.file);
  EXPECT_TRUE(named.contains(first));
  EXPECT_TRUE(named.contains(second));
}

TEST_F(Verify, finds_two_swapped_frames_even_if_the_manifest_agrees) {
  // Sizes, sums and checksums all agree: only the tags of the frames reveal it.
  Manifest m = manifest();
  LayerFile& file = m.segments[1].layers[2];
  const std::string content = read_text(reel() / file.path);
  const std::size_t first = total(file.frames[0]);
  const std::string swapped = content.substr(first) + content.substr(0, first);
  std::swap(file.frames[0], file.frames[1]);
  file.checksum = checksum_of_text(swapped);
  write_file(reel() / file.path, swapped);
  write_file(reel() / "reel.json", write_manifest(m));
  const std::vector<Fault> found = faults();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].file, file.path);
  EXPECT_EQ(found[0].frame, 3u);
  EXPECT_EQ(found[1].frame, 4u);
}

TEST_F(Verify, finds_frames_that_differ_from_the_manifest) {
  Manifest m = manifest();
  m.segments[0].points[1] += 1;
  m.depth_max = m.depth_min = 9;
  write_file(reel() / "reel.json", write_manifest(m));
  const std::vector<Fault> found = faults();
  ASSERT_EQ(found.size(), 5u);
  EXPECT_THAT(found[0].what, HasSubstr("depth"));
  EXPECT_EQ(found[1].frame, 1u);
  EXPECT_THAT(found[1].what, HasSubstr("made of 101 points, the manifest says 102"));
}

TEST_F(Verify, finds_points_outside_of_the_bounds) {
  const Box bounds = manifest().bounds;
  const glm::dvec3 part = 0.1 * bounds.extent();
  for (const Box& wrong : {Box{bounds.min + part, bounds.max}, Box{bounds.min, bounds.max - part},
                           Box{bounds.max, bounds.max + part}}) {
    Manifest m = manifest();
    m.bounds = wrong;
    write_file(reel() / "reel.json", write_manifest(m));
    const std::vector<Fault> found = faults();
    ASSERT_FALSE(found.empty());
    EXPECT_THAT(found[0].what, HasSubstr("outside of the manifest's bounds"));
  }
}

TEST_F(Verify, refuses_a_folder_that_is_not_a_package) {
  const Result<VerifyReport> report = verify(folder() / "in");
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message, StartsWith((folder() / "in").string()));
}

TEST_F(Verify, reports_nothing_when_it_is_stopped) {
  std::stop_source stop;
  InspectListener listener;
  listener.begin = [&](std::uint32_t) { stop.request_stop(); };
  listener.stop = stop.get_token();
  const Result<VerifyReport> report = verify(reel(), listener);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, "interrupted");
}

TEST_F(Unpack, writes_every_frame_near_its_source) {
  int done = 0;
  InspectListener listener;
  listener.begin = [](std::uint32_t total) { EXPECT_EQ(total, 5u); };
  listener.frame_done = [&] { ++done; };
  const Result<UnpackReport> report = unpack(unpacking(), listener);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->frames, 5u);
  EXPECT_EQ(done, 5);
  EXPECT_THAT(names_in(folder() / "out"),
              ElementsAre("frame_00000.ply", "frame_00001.ply", "frame_00002.ply",
                          "frame_00003.ply", "frame_00004.ply"));
  const Manifest m = manifest();
  for (std::uint32_t i = 0; i < 5; ++i) {
    const auto source = read_cloud_file(folder() / "in" / fmt::format("frame_{}.ply", i));
    const auto back = read_cloud_file(folder() / "out" / fmt::format("frame_0000{}.ply", i));
    ASSERT_TRUE(source && back);
    EXPECT_TRUE(back->cloud.has_colors() && back->cloud.has_normals());
    const double voxel = m.segments[locate(m, i).segment].cube.edge / 1024;
    EXPECT_LE(cloud_distance(source->cloud, back->cloud)->max(), 0.5001 * std::sqrt(3.0) * voxel);
  }
}

TEST_F(Unpack, writes_fewer_points_within_half_a_coarse_voxel_from_the_first_layer) {
  fs::remove_all(folder() / "in");
  write_frames(folder() / "in", 1, 20'000);
  PackOptions options = pack_options(folder() / "in", reel());
  options.force = true;
  const Result<PackSummary> summary = pack(options);
  ASSERT_TRUE(summary) << summary.error().message;
  const auto source = read_cloud_file(folder() / "in/frame_0.ply");
  ASSERT_TRUE(source);

  UnpackOptions unpack_options = unpacking();
  unpack_options.force = true;
  std::vector<std::size_t> points;
  for (const int level : {7, 9, 10}) {
    unpack_options.layers = points.size() + 1;
    const Result<UnpackReport> report = unpack(unpack_options);
    ASSERT_TRUE(report) << report.error().message;
    const auto back = read_cloud_file(folder() / "out/frame_00000.ply");
    ASSERT_TRUE(back);
    points.push_back(back->cloud.size());
    const double half_diagonal =
        0.5 * std::sqrt(3.0) * manifest().segments[0].cube.edge / std::exp2(level);
    const CloudDistance distance = cloud_distance(source->cloud, back->cloud).value();
    EXPECT_LE(distance.max(), 1.0001 * half_diagonal) << level;
    EXPECT_LE(distance.d1(), half_diagonal * half_diagonal) << level;
  }
  EXPECT_GT(points[0], 0u);
  EXPECT_LT(points[0], points[1]);
  EXPECT_LE(points[1], points[2]);
  EXPECT_EQ(points[2], summary->coded_points);
}

TEST_F(Unpack, every_point_has_a_normal_where_those_of_the_source_have_no_common_side) {
  PointCloud cloud = ellipsoid(5'000);
  std::mt19937 random(1);
  for (glm::vec3& normal : cloud.normals) normal *= random() % 2 == 0 ? 1.0f : -1.0f;
  fs::remove_all(folder() / "in");
  fs::create_directory(folder() / "in");
  ASSERT_TRUE(write_ply(folder() / "in/0.ply", cloud));
  PackOptions options = pack_options(folder() / "in", reel());
  options.force = true;
  ASSERT_TRUE(pack(options));
  ASSERT_TRUE(unpack(unpacking()));
  const auto back = read_cloud_file(folder() / "out/frame_00000.ply");
  ASSERT_TRUE(back);
  for (const glm::vec3& normal : back->cloud.normals) ASSERT_NEAR(glm::length(normal), 1.0f, 0.01f);
}

TEST_F(Unpack, accepts_a_range_of_frames) {
  UnpackOptions options = unpacking();
  options.first_frame = 2;
  options.last_frame = 3;
  EXPECT_EQ(unpack(options).value_or(UnpackReport{}).frames, 2u);
  EXPECT_THAT(names_in(options.output), ElementsAre("frame_00002.ply", "frame_00003.ply"));
  options.force = true;
  options.first_frame = 4;
  options.last_frame = kToTheEnd;
  EXPECT_EQ(unpack(options).value_or(UnpackReport{}).frames, 1u);
  EXPECT_THAT(names_in(options.output), ElementsAre("frame_00004.ply"));
}

TEST_F(Unpack, refuses_frames_that_do_not_exist) {
  for (const auto& [first, last] : {std::pair(5u, kToTheEnd), {5u, 5u}, {4u, 5u}, {0u, 99u}}) {
    UnpackOptions options = unpacking();
    options.first_frame = first;
    options.last_frame = last;
    const Result<UnpackReport> report = unpack(options);
    ASSERT_FALSE(report) << first << " to " << last;
    EXPECT_THAT(report.error().message, HasSubstr("has 5 frames"));
    EXPECT_FALSE(fs::exists(options.output));
  }
}

TEST_F(Unpack, names_the_damaged_frame_and_leaves_nothing_behind) {
  flip_byte(layer_file("00003.base"), byte_range(manifest().segments[1].layers[0], 1).offset + 70);
  const Result<UnpackReport> report = unpack(unpacking());
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message, HasSubstr("frame 4"));
  const std::string gone = layer_file("00000.full");
  fs::remove(reel() / gone);
  const Result<UnpackReport> missing = unpack(unpacking());
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().message, StartsWith((reel() / gone).string()));
  EXPECT_THAT(names_in(folder()), ElementsAre("in", "reel"));
}

TEST_F(Unpack, leaves_nothing_behind_when_it_is_stopped) {
  std::stop_source stop;
  InspectListener listener;
  listener.frame_done = [&] { stop.request_stop(); };
  listener.stop = stop.get_token();
  const Result<UnpackReport> report = unpack(unpacking(), listener);
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message, StartsWith("interrupted"));
  EXPECT_THAT(names_in(folder()), ElementsAre("in", "reel"));
}

TEST_F(Unpack, replaces_folders_of_unpacked_frames_only) {
  UnpackOptions options = unpacking();
  EXPECT_TRUE(unpack(options));
  const auto before = contents(options.output);
  const Result<UnpackReport> refused = unpack(options);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, StartsWith(options.output.string() + ": exists"));

  options.force = true;
  EXPECT_TRUE(unpack(options));
  EXPECT_EQ(contents(options.output), before);

  write_file(options.output / "frame_1.ply.bak", "mine");
  const Result<UnpackReport> other = unpack(options);
  ASSERT_FALSE(other);
  EXPECT_THAT(other.error().message, HasSubstr("frame_1.ply.bak"));
  EXPECT_EQ(read_text(options.output / "frame_1.ply.bak"), "mine");
  fs::remove(options.output / "frame_1.ply.bak");

  fs::create_directory(options.output / "frame_00009.ply");
  write_file(options.output / "frame_00009.ply" / "a", "mine");
  EXPECT_THAT(unpack(options).error().message, HasSubstr("frame_00009.ply"));
  EXPECT_EQ(read_text(options.output / "frame_00009.ply" / "a"), "mine");
}

TEST_F(Verify, decodes_no_frame_that_takes_more_memory_than_allowed) {
  ASSERT_TRUE(verify(reel())->faults.empty());
  const Result<VerifyReport> report = verify(reel(), {}, 1024);
  ASSERT_TRUE(report);
  ASSERT_FALSE(report->faults.empty());
  EXPECT_THAT(report->faults.front().what, HasSubstr("raise --frame-memory"));
  UnpackOptions options = unpacking();
  options.max_memory = 1024;
  const Result<UnpackReport> unpacked = unpack(options);
  ASSERT_FALSE(unpacked);
  EXPECT_THAT(unpacked.error().message, HasSubstr("raise --frame-memory"));
}

}  // namespace
}  // namespace pointreel::inspect_test
