#include "server/pack/packer.h"

#include <filesystem>
#include <fstream>
#include <stop_token>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "codec/files/cloud_file.h"
#include "codec/octree/frame_header.h"
#include "codec/package/manifest.h"
#include "pointreel/draco.h"
#include "pointreel/package.h"
#include "server/inspect/inspect.h"
#include "tests/depth_scene.h"
#include "tests/packed_clouds.h"

namespace pointreel::packer_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

Manifest manifest_of(const fs::path& reel) {
  Result<Manifest> manifest = read_manifest(reel);
  if (!manifest) ADD_FAILURE() << manifest.error().message;
  return manifest.value_or(Manifest{});
}

PackSummary packed(const PackOptions& options) {
  Result<PackSummary> summary = pack(options);
  if (!summary) ADD_FAILURE() << summary.error().message;
  return summary.value_or(PackSummary{});
}

std::string error_of(const PackOptions& options, const PackListener& listener = {}) {
  const Result<PackSummary> summary = pack(options, listener);
  return summary ? "packed" : summary.error().message;
}

/// Decodes all layers of a frame.
DecodedFrame decoded(const fs::path& reel, std::uint32_t frame) {
  const auto layers = read_frame(reel, manifest_of(reel), frame, SIZE_MAX);
  if (!layers) ADD_FAILURE() << layers.error().message;
  Result<DecodedFrame> result =
      decode_frame(layer_views(layers.value_or(std::vector<Chunks<Bytes>>())));
  if (!result) ADD_FAILURE() << result.error().message;
  return result.value_or(DecodedFrame{});
}

EncodeOptions draco() {
  EncodeOptions options;
  options.codec = DracoOptions{};
  return options;
}

/// The names of the files in a package. Those of layer files are given without their checksums.
std::set<std::string> layers_in(const fs::path& package) {
  std::set<std::string> names;
  for (std::string name : names_in(package)) {
    if (name.ends_with(".prs")) name.erase(name.size() - 13, 9);
    names.insert(name);
  }
  return names;
}

TEST(Packer, estimates_normals_where_players_would_take_long_to_derive_them) {
  const TemporaryFolder folder;
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  fs::create_directories(options.inputs[0]);
  options.encode.codec = OctreeOptions{};
  options.force = true;
  const PointCloud given = ellipsoid(100'000, glm::dvec3(1.0));
  const auto packed_from = [&](PointCloud cloud, MissingNormals missing) {
    EXPECT_TRUE(write_ply(options.inputs[0] / "frame.ply", cloud));
    options.missing_normals = missing;
    const PackSummary summary = packed(options);
    const Manifest manifest = manifest_of(options.output);
    EXPECT_EQ(summary.normals_estimated, manifest.normals_estimated);
    return std::pair(manifest.normals, manifest.normals_estimated);
  };
  PointCloud bare = given;
  bare.normals.clear();
  ASSERT_TRUE(bare.has_colors());
  constexpr auto kIfItPays = MissingNormals::estimated_if_it_pays;
  const std::pair none(false, false), of_source(true, false), estimated(true, true);
  EXPECT_EQ(packed_from(given, kIfItPays), of_source);
  EXPECT_EQ(packed_from(bare, MissingNormals::derived), none);
  EXPECT_EQ(packed_from(bare, kIfItPays), estimated);
  const PointCloud frame = decoded(options.output, 0).cloud;
  std::size_t near = 0;
  for (const glm::vec3& normal : frame.normals) near += glm::length(normal) > 0.9f ? 1 : 0;
  EXPECT_EQ(near, frame.size());

  PointCloud few = ellipsoid(1'000, glm::dvec3(1.0));
  few.normals.clear();
  EXPECT_EQ(packed_from(few, kIfItPays), none);
  EXPECT_EQ(packed_from(few, MissingNormals::estimated), estimated);
  PointCloud grey = bare;
  grey.colors.clear();
  EXPECT_EQ(packed_from(grey, kIfItPays), none);
  options.encode = draco();
  EXPECT_EQ(packed_from(bare, kIfItPays), none);
}

TEST(Packer, writes_the_same_bytes_on_any_number_of_threads) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 10);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  options.segment_frames = 4;
  for (const EncodeOptions& encode : {options.encode, draco()}) {
    for (const bool cube_per_frame : {false, true}) {
      options.encode = encode;
      options.cube_per_frame = cube_per_frame;
      options.force = true;
      options.threads = 1;
      packed(options);
      const auto alone = contents(options.output);
      options.threads = 4;
      packed(options);
      EXPECT_EQ(contents(options.output), alone);
      EXPECT_EQ(alone.size(), encode.id() == Codec::draco ? 4u : 10u);
    }
  }
}

TEST(Packer, writes_the_same_slabs_on_any_number_of_threads) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 3, 12'000);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  options.force = true;
  const auto contents_with = [&](int slabs, int threads) {
    OctreeOptions octree{Entropy::context, DepthRule::fixed(10)};
    octree.slabs = slabs;
    options.encode.codec = octree;
    options.threads = threads;
    packed(options);
    return contents(options.output);
  };
  const auto alone = contents_with(2, 1);
  EXPECT_EQ(contents_with(2, 4), alone);
  EXPECT_NE(contents_with(1, 4), alone) << "the frames were coded without slabs";
}

TEST(Packer, reads_frames_in_natural_order) {
  const TemporaryFolder folder;
  fs::create_directory(folder.path() / "in");
  for (const std::size_t i : {10u, 9u, 100u, 1u, 2u}) {
    ASSERT_TRUE(write_ply(folder.path() / "in" / fmt::format("f{}.ply", i), ellipsoid(i)));
  }
  const PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  packed(options);
  const Manifest manifest = manifest_of(options.output);
  ASSERT_EQ(manifest.segments.size(), 1u);
  EXPECT_THAT(manifest.segments[0].points, ElementsAre(1u, 2u, 9u, 10u, 100u));
}

TEST(Packer, divides_frames_into_segments_that_share_a_cube) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 7);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "take.reel");
  options.segment_frames = 3;
  const PackSummary summary = packed(options);
  const Manifest manifest = manifest_of(options.output);
  EXPECT_EQ(summary.frames, 7u);
  EXPECT_EQ(manifest.name, "take");
  EXPECT_EQ(manifest.duration_us, 280000u);
  ASSERT_EQ(manifest.segments.size(), 3u);
  EXPECT_THAT(manifest.segments[0].times_us, ElementsAre(0u, 40000u, 80000u));
  EXPECT_THAT(manifest.segments[1].times_us, ElementsAre(120000u, 160000u, 200000u));
  EXPECT_THAT(manifest.segments[2].times_us, ElementsAre(240000u));
  EXPECT_THAT(manifest.segments[1].points, ElementsAre(103u, 104u, 105u));
  std::uint32_t frame = 0;
  for (const Segment& segment : manifest.segments) {
    EXPECT_EQ(segment.first_frame, frame);
    for (std::uint32_t i = 0; i < segment.frame_count(); ++i, ++frame) {
      EXPECT_EQ(decoded(options.output, frame).cube, segment.cube) << frame;
    }
  }
  EXPECT_FALSE(manifest.segments[0].cube == manifest.segments[1].cube);
  EXPECT_EQ(
      layers_in(options.output),
      (std::set<std::string>{"reel.json", "00000.base.prs", "00000.middle.prs", "00000.full.prs",
                             "00003.base.prs", "00003.middle.prs", "00003.full.prs",
                             "00006.base.prs", "00006.middle.prs", "00006.full.prs"}));
}

TEST(Packer, gives_each_frame_its_own_cube_on_request) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 3);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  options.cube_per_frame = true;
  packed(options);
  const Manifest manifest = manifest_of(options.output);
  Box all;
  for (std::uint32_t frame = 0; frame < 3; ++frame) {
    const auto source = read_cloud_file(folder.path() / "in" / fmt::format("frame_{}.ply", frame));
    ASSERT_TRUE(source);
    const Box box = bounds(source->cloud);
    EXPECT_EQ(decoded(options.output, frame).cube, bounding_cube(box)) << frame;
    all.grow(box);
  }
  EXPECT_EQ(manifest.bounds, all);
  EXPECT_EQ(manifest.segments[0].cube, bounding_cube(all));
}

TEST(Packer, restores_points_on_multiples_of_the_voxel_exactly) {
  for (const double voxel : {1.0, 0.125}) {
    for (const bool cube_per_frame : {false, true}) {
      const TemporaryFolder folder;
      fs::create_directory(folder.path() / "in");
      std::vector<PointCloud> sources(2);
      for (std::size_t i = 0; i < 500; ++i) {
        const glm::ivec3 cell(i % 10, i / 10 % 10 + i / 250, i / 100);
        sources[i % 2].positions.emplace_back(glm::vec3(cell * 7 - 30) * static_cast<float>(voxel));
      }
      for (std::size_t i = 0; i < 2; ++i) {
        ASSERT_TRUE(write_ply(folder.path() / "in" / fmt::format("{}.ply", i), sources[i]));
      }
      PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
      options.voxel = voxel;
      options.cube_per_frame = cube_per_frame;
      packed(options);
      for (std::uint32_t i = 0; i < 2; ++i) {
        EXPECT_EQ(world_points(decoded(options.output, i).cloud), world_points(sources[i]));
      }
    }
  }
}

TEST(Packer, refuses_voxels_that_need_too_deep_an_octree) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 1);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  for (const double voxel : {1e-7, 1e-300, 1e-320}) {
    options.voxel = voxel;
    const std::string error = error_of(options);
    EXPECT_THAT(error, StartsWith((folder.path() / "in/frame_0.ply").string() + ": voxels of"));
    EXPECT_THAT(names_in(folder.path()), ElementsAre("in"));
  }
}

TEST(Packer, names_files_by_content_so_that_caches_never_mix_them) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 2);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  ASSERT_TRUE(pack(options));
  const std::set<std::string> before = names_in(options.output);
  options.force = true;
  ASSERT_TRUE(pack(options));
  EXPECT_EQ(names_in(options.output), before);
  std::get<OctreeOptions>(options.encode.codec).depth = DepthRule::fixed(3);
  ASSERT_TRUE(pack(options));
  for (const std::string& name : names_in(options.output)) {
    EXPECT_TRUE(name == "reel.json" || !before.contains(name)) << name;
  }
}

TEST(Packer, leaves_an_existing_folder_untouched_without_force) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 2);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  packed(options);
  const auto before = contents(options.output);
  options.encode = draco();
  EXPECT_THAT(error_of(options), StartsWith(options.output.string() + ": exists"));
  EXPECT_EQ(contents(options.output), before);
  EXPECT_THAT(names_in(folder.path()), ElementsAre("in", "reel"));
}

TEST(Packer, replaces_a_package_with_force) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 2);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  packed(options);
  options.encode = draco();
  options.force = true;
  packed(options);
  EXPECT_THAT(layers_in(options.output), ElementsAre("00000.full.prs", "reel.json"));
  EXPECT_EQ(manifest_of(options.output).codec, "draco");
  EXPECT_THAT(names_in(folder.path()), ElementsAre("in", "reel"));
}

TEST(Packer, replaces_what_killed_programs_have_left_and_nothing_that_is_being_written) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 2);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  packed(options);
  options.force = true;
  const auto put = [&](const std::string& name) { std::ofstream(options.output / name) << "x"; };
  put("reel.json.2147483000~");  // no system has so many processes
  put("audio.0123abcd.opus.2147483000~");
  put("audio.0123abcd.opus");
  packed(options);
  EXPECT_FALSE(fs::exists(options.output / "audio.0123abcd.opus"));
  put("reel.json." + std::to_string(::getpid()) + "~");
  EXPECT_THAT(error_of(options), HasSubstr("is writing to it; wait until it ends"));
  fs::remove(options.output / ("reel.json." + std::to_string(::getpid()) + "~"));
  put("audio.mine.opus");
  EXPECT_THAT(error_of(options), HasSubstr("holds audio.mine.opus, which is not part of"));
}

TEST(Packer, never_replaces_a_folder_that_is_not_a_package_even_with_force) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 1);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "in");
  options.force = true;
  const auto sources = contents(folder.path() / "in");
  EXPECT_THAT(error_of(options), HasSubstr("is not a package"));
  EXPECT_EQ(contents(folder.path() / "in"), sources);

  options.output = folder.path() / "reel";
  packed(options);
  write_file(options.output / "notes.txt", "mine");
  EXPECT_THAT(error_of(options), HasSubstr("notes.txt"));
  EXPECT_EQ(read_text(options.output / "notes.txt"), "mine");
  fs::remove(options.output / "notes.txt");

  write_file(options.output / "00000.base.00000000.prs", "mine");
  EXPECT_THAT(error_of(options), HasSubstr("00000.base.00000000.prs"));
  fs::remove(options.output / "00000.base.00000000.prs");

  write_file(options.output / "reel.json", "damaged");
  EXPECT_THAT(error_of(options), HasSubstr("reel.json is damaged"));
  EXPECT_THAT(names_in(folder.path()), ElementsAre("in", "reel"));
}

TEST(Packer, names_a_file_that_cannot_be_read_and_leaves_nothing_behind) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 5);
  const fs::path bad = folder.path() / "in" / "frame_3.ply";
  fs::resize_file(bad, fs::file_size(bad) - 5);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  options.segment_frames = 2;  // by then, a segment is complete
  for (const bool cube_per_frame : {false, true}) {
    options.cube_per_frame = cube_per_frame;
    EXPECT_THAT(error_of(options), StartsWith(bad.string() + ": "));
    EXPECT_THAT(names_in(folder.path()), ElementsAre("in"));
  }
}

TEST(Packer, leaves_nothing_behind_when_it_is_stopped) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 6);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  options.segment_frames = 3;
  for (const int frames_before : {0, 1, 3, 4}) {
    std::stop_source stop;
    int done = 0;
    PackListener listener;
    listener.begin = [&](std::uint32_t total) {
      EXPECT_EQ(total, 6u);
      if (frames_before == 0) stop.request_stop();
    };
    listener.frame_done = [&] {
      if (++done == frames_before) stop.request_stop();
    };
    listener.stop = stop.get_token();
    EXPECT_THAT(error_of(options, listener), HasSubstr("interrupted")) << frames_before;
    EXPECT_EQ(done, frames_before);
    EXPECT_THAT(names_in(folder.path()), ElementsAre("in"));
  }
}

TEST(Packer, omits_attributes_on_request) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 2);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  options.force = true;
  options.measure_parts = true;
  for (const EncodeOptions& encode : {options.encode, draco()}) {
    for (const bool colors : {false, true}) {
      for (const bool normals : {false, true}) {
        options.encode = encode;
        options.encode.colors = colors;
        options.encode.normals = normals;
        const PackSummary summary = packed(options);
        const Manifest manifest = manifest_of(options.output);
        EXPECT_EQ(manifest.colors, colors);
        EXPECT_EQ(manifest.normals, normals);
        EXPECT_EQ(summary.parts.value().colors > 0, colors);
        EXPECT_EQ(summary.parts.value().normals > 0, normals);
        const PointCloud cloud = decoded(options.output, 1).cloud;
        EXPECT_EQ(cloud.has_colors(), colors);
        EXPECT_EQ(cloud.has_normals(), normals);
      }
    }
  }
}

TEST(Packer, states_that_a_reel_lacks_attributes_that_its_sources_lack) {
  const TemporaryFolder folder;
  fs::create_directory(folder.path() / "in");
  PointCloud plain = ellipsoid(50);
  plain.colors.clear();
  plain.normals.clear();
  ASSERT_TRUE(write_ply(folder.path() / "in/0.ply", plain));
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  options.force = true;
  for (const EncodeOptions& encode : {options.encode, draco()}) {
    options.encode = encode;
    packed(options);
    const Manifest manifest = manifest_of(options.output);
    EXPECT_FALSE(manifest.colors);
    EXPECT_FALSE(manifest.normals);
  }
}

TEST(Packer, packs_frames_without_points) {
  for (const EncodeOptions& encode : {EncodeOptions{}, draco()}) {
    for (const bool cube_per_frame : {false, true}) {
      const TemporaryFolder folder;
      write_frames(folder.path() / "in", 3);
      ASSERT_TRUE(write_ply(folder.path() / "in/frame_1.ply", PointCloud{}));
      PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
      options.encode = encode;
      options.cube_per_frame = cube_per_frame;
      packed(options);
      EXPECT_THAT(manifest_of(options.output).segments[0].points, ElementsAre(100u, 0u, 102u));

      const Result<VerifyReport> report = verify(options.output);
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_THAT(report->faults, IsEmpty());
      const auto count = unpack({options.output, folder.path() / "out"});
      ASSERT_TRUE(count) << count.error().message;
      const auto back = read_cloud_file(folder.path() / "out/frame_00001.ply");
      ASSERT_TRUE(back) << back.error().message;
      EXPECT_TRUE(back->cloud.empty());
    }
  }
}

TEST(Packer, packs_a_reel_without_any_points) {
  const TemporaryFolder folder;
  fs::create_directory(folder.path() / "in");
  ASSERT_TRUE(write_ply(folder.path() / "in/0.ply", PointCloud{}));
  const PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  EXPECT_EQ(packed(options).points, 0u);
  EXPECT_TRUE(manifest_of(options.output).bounds.empty());
  const Result<VerifyReport> report = verify(options.output);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_THAT(report->faults, IsEmpty());
}

TEST(Packer, omits_layers_that_no_frame_has) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 2);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  options.encode.codec = OctreeOptions{Entropy::none, DepthRule::fixed(5)};
  packed(options);
  EXPECT_THAT(manifest_of(options.output).layer_names, ElementsAre("base"));
  EXPECT_THAT(layers_in(options.output), ElementsAre("00000.base.prs", "reel.json"));
}

TEST(Packer, summarises_its_output) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 4);
  const PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  const PackSummary summary = packed(options);
  std::uint64_t bytes = 0, segment_bytes = 0, coded = 0;
  for (const auto& [name, content] : contents(options.output)) {
    bytes += content.size();
    if (name != "reel.json") segment_bytes += content.size();
  }
  for (std::uint32_t i = 0; i < 4; ++i) coded += decoded(options.output, i).cloud.size();
  EXPECT_EQ(summary.bytes, bytes);
  EXPECT_EQ(summary.segment_bytes, segment_bytes);
  EXPECT_EQ(total(summary.parts.value()), segment_bytes);
  EXPECT_EQ(summary.points, 100u + 101u + 102u + 103u);
  EXPECT_EQ(summary.coded_points, coded);
  EXPECT_EQ(summary.depth_min, 10u);
  EXPECT_EQ(summary.depth_max, 10u);
  EXPECT_GT(summary.encode_ms.min, 0.0);
  EXPECT_LE(summary.encode_ms.min, summary.encode_ms.median);
  EXPECT_LE(summary.encode_ms.median, summary.encode_ms.max);
}

TEST(Packer, warns_of_repairs_and_omissions) {
  const TemporaryFolder folder;
  fs::create_directory(folder.path() / "in");
  PointCloud cloud = ellipsoid(20);
  cloud.radii.assign(20, 0.5f);
  cloud.positions[3].y = std::nanf("");
  ASSERT_TRUE(write_ply(folder.path() / "in/0.ply", cloud));
  ASSERT_TRUE(write_ply(folder.path() / "in/1.ply", cloud));
  std::vector<std::string> lines;
  PackListener listener;
  listener.warn = [&](const std::string& line) { lines.push_back(line); };
  const auto summary = pack(pack_options(folder.path() / "in", folder.path() / "reel"), listener);
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->warnings, lines);
  EXPECT_THAT(lines, ElementsAre(HasSubstr("radii"),
                                 StartsWith((folder.path() / "in/0.ply").string() + ": "),
                                 StartsWith((folder.path() / "in/1.ply").string() + ": ")));
}

TEST(Packer, reads_depth_within_the_memory_that_a_frame_may_take) {
  const TemporaryFolder folder;
  depth_scene::write(folder.path() / "in", 2, depth_scene::camera());
  PackOptions options;
  options.inputs = {folder.path() / "in"};
  options.output = folder.path() / "reel";
  options.max_memory = 100'000;
  EXPECT_THAT(error_of(options), HasSubstr("raise --frame-memory"));
}

TEST(Packer, warns_of_voxels_that_hold_nearly_all_points) {
  const TemporaryFolder folder;
  fs::create_directory(folder.path() / "in");
  PointCloud cloud;
  for (int i = 0; i < 5000; ++i) cloud.positions.emplace_back(i % 70, i / 70, 0);
  ASSERT_TRUE(write_ply(folder.path() / "in/0.ply", cloud));
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  options.voxel = 1000.0;
  std::get<OctreeOptions>(options.encode.codec).depth = DepthRule::fixed(1);
  const auto summary = pack(options);
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_THAT(summary->warnings, ElementsAre(HasSubstr("its 5000 points fall into 1 voxel")));
}

TEST(Packer, compares_frames_with_what_it_decodes_whatever_that_takes) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 2);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  options.max_memory = 1;  // bounds what hostile files take, and PLY files take no more than theirs
  const auto summary = pack(options);
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_TRUE(summary->coding_error);
}

TEST(Packer, refuses_values_that_no_client_accepts_before_it_begins) {
  const TemporaryFolder folder;
  write_frames(folder.path() / "in", 2);
  PackOptions options = pack_options(folder.path() / "in", folder.path() / "reel");
  options.name = std::string(256, 'a');
  bool begun = false;
  PackListener listener;
  listener.begin = [&](std::uint32_t) { begun = true; };
  EXPECT_THAT(error_of(options, listener), StartsWith("name: "));
  options.name = "slow";
  options.fps = 1e-12;
  EXPECT_THAT(error_of(options, listener), StartsWith("duration_us: "));
  EXPECT_FALSE(begun);
  EXPECT_THAT(names_in(folder.path()), ElementsAre("in"));
}

TEST(Spread, consists_of_the_median_and_both_extremes) {
  EXPECT_EQ(spread_of({3.0, 1.0, 2.0}).median, 2.0);
  const Spread even = spread_of({4.0, 1.0, 2.0, 9.0});
  EXPECT_EQ(even.median, 3.0);
  EXPECT_EQ(even.min, 1.0);
  EXPECT_EQ(even.max, 9.0);
  EXPECT_EQ(spread_of({}).max, 0.0);
}

}  // namespace
}  // namespace pointreel::packer_test
