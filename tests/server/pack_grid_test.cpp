#include <filesystem>
#include <initializer_list>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/files/cloud_file.h"
#include "codec/package/manifest.h"
#include "pointreel/draco.h"
#include "server/inspect/inspect.h"
#include "server/pack/packer.h"
#include "tests/pack_folder.h"

namespace pointreel::pack_grid_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

/// In which grid frames are packed, and what happens if none suits them.
class PackGrid : public PackFolder {
 protected:
  PackGrid() { options_.encode.codec = OctreeOptions{}; }

  std::string error() {
    const Result<PackSummary> summary = pack(options_);
    return summary ? "packed" : summary.error().message;
  }

  PointCloud decoded(std::uint32_t frame) {
    const auto layers = read_frame(options_.output, *read_manifest(options_.output), frame, 9);
    return decode_frame(layer_views(*layers))->cloud;
  }

  void use(const EncodeOptions& encode) { options_.encode = encode; }
};

EncodeOptions octree(DepthRule depth) { return {OctreeOptions{Entropy::context, depth}}; }

EncodeOptions draco(int bits) {
  DracoOptions options;
  options.position_bits = bits;
  return {options};
}

/// A surface of voxels as a scan of 9 bits has them, each once, and shifted.
PointCloud voxelised(const glm::dvec3& shift, double voxel) {
  const PointCloud smooth = ellipsoid(40'000);
  std::set<std::array<int, 3>> cells;
  for (const glm::vec3& p : smooth.positions) {
    const glm::ivec3 cell(glm::round(p * 150.0f));
    cells.insert({cell.x, cell.y, cell.z});
  }
  PointCloud cloud;
  for (const auto& [x, y, z] : cells) {
    cloud.positions.emplace_back((glm::dvec3(x, y, z) + shift) * voxel);
  }
  return cloud;
}

TEST_F(PackGrid, voxelised_frames_come_back_exactly_if_the_depth_suffices) {
  for (const glm::dvec3 shift : {glm::dvec3(0.0), glm::dvec3(0.5)}) {
    const std::vector<PointCloud> sources = {voxelised(shift, 1.0),
                                             voxelised(shift + glm::dvec3(3, 0, -7), 1.0)};
    for (int i = 0; i < 2; ++i) write(i, sources[static_cast<std::size_t>(i)]);
    for (const bool cube_per_frame : {false, true}) {
      options_.cube_per_frame = cube_per_frame;
      for (const EncodeOptions& encode : {octree(DepthRule{}), octree(DepthRule::fixed(9)),
                                          octree(DepthRule::fixed(12)), draco(9), draco(11)}) {
        use(encode);
        const PackSummary summary = packed();
        EXPECT_EQ(summary.depth_max, 9u) << "no voxel is divided";
        EXPECT_EQ(summary.max_error, 0.0);
        EXPECT_EQ(max_error(options_.output, *read_manifest(options_.output)).value(), 0.0);
        for (std::uint32_t i = 0; i < 2; ++i) {
          EXPECT_EQ(world_points(decoded(i)), world_points(sources[i]));
        }
      }
      for (const EncodeOptions& encode : {octree(DepthRule::fixed(8)), draco(8)}) {
        use(encode);
        EXPECT_GT(packed().max_error, 0.4);
      }
    }
  }
}

TEST_F(PackGrid, merged_voxels_do_not_shift_what_they_show) {
  // 0.25 does not merge whole voxels of 0.1, and leaves on multiples of it are right on average.
  for (const glm::dvec3 shift : {glm::dvec3(0.0), glm::dvec3(0.5)}) {
    const PointCloud source = voxelised(shift, 0.1);
    write(0, source);
    for (const double voxel : {0.1, 0.2, 0.25, 0.3, 0.4, 0.8}) {
      options_.voxel = voxel;
      for (const bool cube_per_frame : {false, true}) {
        options_.cube_per_frame = cube_per_frame;
        packed();
        const PointCloud leaves = decoded(0);
        // Each source point counts, so that surfaces do not pull the mean to where leaves are many.
        glm::dvec3 shifted(0.0);
        for (const glm::vec3& p : source.positions) {
          const glm::dvec3 from = leaves.origin + glm::dvec3(leaves.positions.front());
          const glm::dvec3 offset = (glm::dvec3(p) - from) / voxel;
          shifted += offset - glm::floor(offset + 0.5 + 1e-5);
        }
        shifted /= static_cast<double>(source.size());
        EXPECT_LT(std::max({std::abs(shifted.x), std::abs(shifted.y), std::abs(shifted.z)}), 0.02)
            << "voxels of " << voxel;
        fs::remove_all(options_.output);
      }
    }
  }
}

TEST_F(PackGrid, frames_are_not_voxelised_if_one_of_them_is_not) {
  write(0, voxelised({}, 0.001));
  PointCloud shifted = voxelised({}, 0.001);
  for (glm::vec3& p : shifted.positions) p.x += 0.0004f;
  write(1, shifted);
  EXPECT_GT(packed().max_error, 1e-4);
  options_.cube_per_frame = true;
  EXPECT_LT(packed().max_error, 1e-7);
}

TEST_F(PackGrid, fine_coordinates_of_sparse_points_do_not_count_as_voxels) {
  // Whole numbers, but far fewer points than voxels.
  std::mt19937 random(1);
  std::uniform_int_distribution<int> anywhere(0, 60'000);
  PointCloud cloud;
  for (int i = 0; i < 500; ++i) {
    cloud.positions.emplace_back(anywhere(random), anywhere(random), anywhere(random));
  }
  write(0, cloud);
  packed();
  EXPECT_EQ(read_manifest(options_.output)->segments[0].cube,
            bounding_cube(bounds(read_cloud_file(in() / "0.ply")->cloud)));
}

TEST_F(PackGrid, takes_vertices_that_are_repeated_with_other_roundings) {
  const PointCloud once = ellipsoid(2000);
  std::mt19937 random(2);
  for (const float jitter : {1e-7f, 1e-6f, 1e-5f}) {
    std::uniform_real_distribution<float> rounding(-jitter, jitter);
    PointCloud soup;
    for (int copy = 0; copy < 8; ++copy) {
      for (const glm::vec3& p : once.positions)
        soup.positions.push_back(p +
                                 glm::vec3(rounding(random), rounding(random), rounding(random)));
    }
    write(0, soup);
    use(octree(DepthRule{}));
    EXPECT_THAT(packed().warnings, IsEmpty()) << jitter;
    fs::remove_all(options_.output);
  }
}

/// With points at these distances on the x axis besides.
PointCloud with_far_points(PointCloud cloud, std::initializer_list<float> distances) {
  for (const float distance : distances) {
    cloud.positions.emplace_back(distance, 0.0f, 0.0f);
    cloud.normals.emplace_back(0.0f, 0.0f, 1.0f);
    cloud.colors.emplace_back(0);
  }
  return cloud;
}

TEST_F(PackGrid, refuses_a_frame_that_far_points_make_too_large) {
  use(octree(DepthRule{}));
  write(0, with_far_points(ellipsoid(2000), {-1e7f, 1e7f}));
  EXPECT_THAT(error(), StartsWith((in() / "0.ply").string() +
                                  ": 2 points lie far from all others, such as point 2000 at "
                                  "-1e+07 0 0: remove such points, or let --best-effort"));
  // No point is far from all others.
  write(0, with_far_points(ellipsoid(2000), {50.0f, 2.5e3f, 1.2e5f, 6e6f, 3e8f}));
  EXPECT_THAT(error(), HasSubstr("some lie too far away for an octree of 21 levels, such as the "
                                 "point at 3e+08 0 0"));
}

TEST_F(PackGrid, names_the_frame_that_has_a_stray_and_leaves_it_out_if_told_to_do_its_best) {
  for (int i = 0; i < 6; ++i)
    write(i, i == 3 ? with_far_points(ellipsoid(2000), {1e7f}) : ellipsoid(2000));
  use(octree(DepthRule{}));
  const std::string stray = (in() / "3.ply").string() + ": point 2000 at 1e+07 0 0 lies far";
  for (const bool cube_per_frame : {false, true}) {
    options_.cube_per_frame = cube_per_frame;
    for (const std::optional<double> voxel : {std::optional<double>(), std::optional(0.001)}) {
      options_.voxel = voxel;
      EXPECT_THAT(error(), StartsWith(stray));
      EXPECT_THAT(error(), Not(HasSubstr("--cube frame")));
    }
    options_.voxel.reset();
    for (const EncodeOptions& encode : {octree(DepthRule::fixed(10)), draco(11)}) {
      use(encode);
      EXPECT_THAT(error(), StartsWith(stray));
    }
    use(octree(DepthRule{}));
  }
  options_.best_effort = true;
  for (const bool cube_per_frame : {false, true}) {
    options_.cube_per_frame = cube_per_frame;
    const PackSummary summary = packed();
    EXPECT_THAT(summary.warnings, ElementsAre(StartsWith(stray)));
    EXPECT_EQ(summary.points, 12'000u);
    EXPECT_LT(summary.max_error, 0.1);
    EXPECT_GT(decoded(3).size(), 1500u);
  }
}

TEST_F(PackGrid, shows_the_frame_before_one_that_cannot_be_read_if_told_to_do_its_best) {
  for (int i = 0; i < 4; ++i) write(i, ellipsoid(100 + static_cast<std::size_t>(i)));
  for (const int i : {0, 2}) fs::resize_file(in() / fmt::format("{}.ply", i), 500);
  EXPECT_THAT(error(), StartsWith((in() / "0.ply").string() + ": byte 500: the data end"));
  options_.best_effort = true;
  for (const bool cube_per_frame : {false, true}) {
    options_.cube_per_frame = cube_per_frame;
    const PackSummary summary = packed();
    EXPECT_EQ(summary.frames, 4u);
    EXPECT_EQ(summary.unreadable_frames, 2u);
    EXPECT_THAT(summary.warnings,
                ElementsAre(AllOf(StartsWith((in() / "0.ply").string() + ": byte 500: the data"),
                                  HasSubstr("1.ply is shown in its place")),
                            AllOf(StartsWith((in() / "2.ply").string() + ": byte 500: the data"),
                                  HasSubstr("1.ply is shown in its place"))));
    EXPECT_EQ(summary.points, 101u * 3 + 103);
  }
}

TEST_F(PackGrid, warnings_of_one_kind_are_told_some_times_and_then_counted) {
  for (int i = 0; i < 30; ++i) {
    PointCloud cloud = ellipsoid(100 + static_cast<std::size_t>(i));
    for (int k = 0; k < 10 + i; ++k) cloud.normals[static_cast<std::size_t>(k)] = glm::vec3(0.0f);
    write(i, cloud);
  }
  options_.segment_frames = 7;
  const std::vector<std::string> warnings = packed().warnings;
  ASSERT_EQ(warnings.size(), 9u);
  EXPECT_THAT(warnings[7], HasSubstr("7.ply: 17 points have no usable normal"));
  EXPECT_THAT(warnings[8], StartsWith("22 more like this: "));
  EXPECT_THAT(warnings[8], HasSubstr("N.ply: N points have no usable normal"));
}

TEST_F(PackGrid, an_empty_frame_may_be_in_a_segment_with_a_stray_point) {
  PointCloud stray = ellipsoid(2000);
  stray.positions.push_back({1e6f, 0.0f, 0.0f});
  stray.colors.push_back(stray.colors.front());
  stray.normals.push_back(stray.normals.front());
  write(0, PointCloud());
  write(1, stray);
  write(2, ellipsoid(2000));
  for (const EncodeOptions& encode :
       {octree(DepthRule{}), octree(DepthRule::fixed(8)), draco(11)}) {
    use(encode);
    EXPECT_THAT(error(), HasSubstr("1.ply: its 2001 points collapse"));
  }
}

TEST_F(PackGrid, an_empty_frame_stands_where_none_can_be_read) {
  write(0, ellipsoid(100));
  fs::resize_file(in() / "0.ply", 500);
  options_.best_effort = true;
  EXPECT_THAT(packed().warnings, ElementsAre(HasSubstr("an empty frame is shown in its place")));
  EXPECT_EQ(read_manifest(options_.output)->frame_count(), 1u);
}

TEST_F(PackGrid, frames_keep_their_time_where_others_are_missing_if_asked_to) {
  for (const int i : {1, 2, 3, 7}) write(i, ellipsoid(100));
  EXPECT_THAT(packed().warnings, ElementsAre(HasSubstr("3 frames are missing")));
  EXPECT_EQ(read_manifest(options_.output)->duration_us, 160'000u);
  options_.keep_gaps = options_.times_of_files = true;
  EXPECT_FALSE(packed().recorded_fps);
  const Manifest manifest = *read_manifest(options_.output);
  EXPECT_EQ(manifest.duration_us, 280'000u);
  EXPECT_EQ(manifest.fps, 25.0);
  EXPECT_FALSE(manifest.captured_us);
  EXPECT_THAT(manifest.segments.at(0).times_us, ElementsAre(0, 40'000, 80'000, 240'000));
}

TEST_F(PackGrid, refuses_frames_that_lie_too_far_apart_for_one_cube) {
  for (const int frame : {0, 1}) {
    PointCloud cloud = ellipsoid(2000);
    cloud.origin.x = 8e6 * frame;
    write(frame, cloud);
  }
  for (const EncodeOptions& encode :
       {octree(DepthRule{}), octree(DepthRule::fixed(10)), draco(11)}) {
    use(encode);
    EXPECT_THAT(error(), StartsWith((in() / "0.ply").string() + ": its 2000 points collapse"));
    EXPECT_THAT(error(), HasSubstr("give --cube frame, or --best-effort"));
    EXPECT_FALSE(fs::exists(options_.output));
    options_.cube_per_frame = true;
    const PackSummary apart = packed();
    EXPECT_LT(apart.max_error, 0.05);
    EXPECT_THAT(apart.warnings, IsEmpty());
    options_.cube_per_frame = false;
    options_.best_effort = true;
    EXPECT_THAT(packed().warnings, ElementsAre(HasSubstr("0.ply: its 2000 points collapse"),
                                               HasSubstr("1.ply: its 2000 points collapse")));
    options_.best_effort = false;
    fs::remove_all(options_.output);
  }
}

TEST_F(PackGrid, refuses_a_frame_of_which_some_points_are_too_far_away) {
  write(0, with_far_points(ellipsoid(2000), {3e8f}));
  for (const bool cube_per_frame : {false, true}) {
    options_.cube_per_frame = cube_per_frame;
    EXPECT_THAT(error(), HasSubstr("point 2000 at 3e+08 0 0 lies far from all others"));
  }
}

TEST_F(PackGrid, names_a_stray_that_only_makes_voxels_larger) {
  write(0, with_far_points(ellipsoid(2000), {1e3f}));
  EXPECT_THAT(
      packed().warnings,
      ElementsAre(HasSubstr("0.ply: point 2000 at 1000 0 0 lies far from all others, so "
                            "voxels may be larger: remove such points, or let --best-effort")));
}

TEST_F(PackGrid, packs_equal_points_and_frames_that_are_small_anyway) {
  PointCloud equal = ellipsoid(50);
  for (std::size_t i = 5; i < 50; ++i) equal.positions[i] = equal.positions[i % 5];
  write(0, equal);
  PointCloud single;
  single.positions.emplace_back(5000.0f, 0.25f, 0.75f);
  write(1, single);
  for (const EncodeOptions& encode : {octree(DepthRule{}), draco(11)}) {
    use(encode);
    options_.cube_per_frame = true;
    EXPECT_THAT(packed().warnings, IsEmpty());
  }
  fs::remove(in() / "0.ply");
  write(0, single);
  options_.cube_per_frame = false;
  EXPECT_THAT(packed().warnings, IsEmpty());
}

TEST_F(PackGrid, fails_if_a_bit_rate_cannot_be_met_unless_told_to_do_its_best) {
  for (int i = 0; i < 4; ++i) write(i, ellipsoid(300));
  options_.segment_frames = 2;
  options_.bitrate = 1000.0;
  EXPECT_THAT(error(), StartsWith("frames 0 to 1 take "));
  EXPECT_THAT(error(), HasSubstr("give a higher --bitrate, or --best-effort"));
  EXPECT_THAT(names_in(folder_.path()), ElementsAre("in"));
  options_.best_effort = true;
  const PackSummary summary = packed();
  for (const SegmentSummary& segment : summary.segments) {
    EXPECT_FALSE(segment.within_rate);
    EXPECT_EQ(segment.depth_max, 1u);
  }
  ASSERT_EQ(summary.warnings.size(), 2u);
  EXPECT_THAT(summary.warnings[1], HasSubstr("frames 2 to 3"));
}

TEST_F(PackGrid, names_each_property_that_it_drops_once) {
  const auto write_text = [&](int frame, const std::string& extra, const std::string& values) {
    std::string text = "ply\nformat ascii 1.0\nelement vertex 2\n";
    for (const char* name : {"x", "y", "z"}) text += fmt::format("property float {}\n", name);
    text += "property float radius\n";
    // As many fields as a cloud can have. What follows them is dropped.
    std::string fields;
    for (std::size_t i = 0; i < kMaxScalars; ++i) {
      text += fmt::format("property float field{}\n", i);
      fields += "0 ";
    }
    text += extra + "end_header\n";
    for (int i = 0; i < 2; ++i) text += fmt::format("{} 0 1.5 1 {}{}\n", i, fields, values);
    write_file(in() / fmt::format("{}.ply", frame), text);
  };
  const std::string quality = "property float quality\nproperty list uchar int friends\n";
  write_text(0, quality, "0.5 1 7");
  write_text(1, quality + "property uchar alpha\n", "0.5 1 7 255");
  write_text(2, quality + "property int label\n", "0.5 1 7 3");
  options_.segment_frames = 2;
  EXPECT_THAT(packed().warnings,
              ElementsAre(HasSubstr("radii"), "properties not packed: alpha, quality",
                          "properties not packed: label"));
}

}  // namespace
}  // namespace pointreel::pack_grid_test
