// Scalar fields on their way through packages and streams.

#include <cmath>
#include <filesystem>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/playback/reel_layers.h"
#include "codec/core/scalar_fields.h"
#include "codec/files/cloud_file.h"
#include "codec/package/manifest.h"
#include "server/inspect/inspect.h"
#include "tests/pack_folder.h"

namespace pointreel::scalar_package_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class ScalarPackage : public PackFolder {
 protected:
  /// Points of which every third has no known temperature.
  static PointCloud cloud(float warmer = 0.0f) {
    PointCloud made = ellipsoid(400);
    made.scalars = {{"temperature", {}}, {"class", {}}};
    for (std::size_t i = 0; i < made.size(); ++i) {
      made.scalars[0].values.push_back(i % 3 == 0 ? std::numeric_limits<float>::quiet_NaN()
                                                  : 20.0f + warmer + made.positions[i].x);
      made.scalars[1].values.push_back(static_cast<float>(i % 4));
    }
    return made;
  }

  Manifest manifest() const { return read_manifest(options_.output).value(); }
  OctreeOptions& octree() { return std::get<OctreeOptions>(options_.encode.codec); }

  fs::path unpacked() {
    const fs::path out = folder_.path() / "out";
    const auto report = unpack({.input = options_.output, .output = out, .force = true});
    EXPECT_TRUE(report) << report.error().message;
    return out;
  }
};

TEST_F(ScalarPackage, has_the_fields_of_its_files_in_a_layer_of_their_own) {
  write(0, cloud());
  write(1, cloud(5.0f));
  write(2, ellipsoid(100));
  const PackSummary summary = packed();
  EXPECT_THAT(summary.warnings, IsEmpty());
  EXPECT_GT(summary.scalar_bytes, 100u);
  EXPECT_EQ(summary.parts->geometry + summary.parts->colors + summary.parts->normals +
                summary.scalar_bytes,
            summary.segment_bytes);
  const Manifest reel = manifest();
  EXPECT_THAT(reel.layer_names, ElementsAre("base", "middle", "full", "scalars"));
  ASSERT_EQ(reel.scalars.size(), 2u);
  EXPECT_EQ(reel.scalars[0].name, "temperature");
  EXPECT_NEAR(reel.scalars[0].least, 19.0, 0.1);
  EXPECT_NEAR(reel.scalars[0].most, 26.0, 0.1);
  EXPECT_FALSE(reel.scalars[0].labels);
  EXPECT_EQ(reel.scalars[1], (ScalarRange{"class", 0, 3, true}));
  EXPECT_EQ(reel.segments[0].layers[3].frames[2].geometry, 0u);
  const auto report = verify(options_.output);
  ASSERT_TRUE(report);
  EXPECT_THAT(report->faults, IsEmpty());
}

TEST_F(ScalarPackage, unpacks_into_files_with_the_fields) {
  write(0, cloud());
  packed();
  const auto loaded = read_cloud_file(unpacked() / "frame_00000.ply");
  ASSERT_TRUE(loaded) << loaded.error().message;
  const PointCloud& points = loaded->cloud;
  ASSERT_EQ(points.scalars.size(), 2u);
  std::size_t unknown = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float temperature = points.scalars[0].values[i];
    if (std::isnan(temperature))
      ++unknown;
    else
      EXPECT_NEAR(temperature, 20.0 + points.world(i).x, 0.01);
  }
  EXPECT_NEAR(static_cast<double>(unknown), static_cast<double>(points.size()) / 3.0, 5.0);
  EXPECT_EQ(summary_of(points.scalars[1].values).distinct, 4u);
}

TEST_F(ScalarPackage, has_its_fields_in_shallow_trees_too) {
  write(0, cloud());
  octree().depth = DepthRule::fixed(6);
  packed();
  EXPECT_THAT(manifest().layer_names, ElementsAre("base", "scalars"));
  EXPECT_THAT(verify(options_.output)->faults, IsEmpty());
  EXPECT_TRUE(read_cloud_file(unpacked() / "frame_00000.ply")->cloud.has_scalars());
}

TEST_F(ScalarPackage, is_as_without_fields_if_they_are_left_out) {
  write(0, cloud());
  octree().scalars = false;
  packed();
  EXPECT_THAT(manifest().layer_names, ElementsAre("base", "middle", "full"));
  EXPECT_THAT(manifest().scalars, IsEmpty());
  const Manifest without = manifest();
  PointCloud bare = cloud();
  bare.scalars.clear();
  write(0, bare);
  octree().scalars = true;
  packed();
  EXPECT_EQ(write_manifest(manifest()), write_manifest(without));
}

TEST_F(ScalarPackage, of_draco_warns_once_that_it_has_no_fields) {
  write(0, cloud());
  write(1, cloud());
  options_.encode.codec = DracoOptions{};
  EXPECT_THAT(packed().warnings, ElementsAre(HasSubstr("scalar fields")));
  EXPECT_THAT(manifest().scalars, IsEmpty());
}

TEST_F(ScalarPackage, that_lacks_the_layer_of_fields_is_not_whole) {
  write(0, cloud());
  packed();
  const Manifest reel = manifest();
  const LayerFile& file = reel.segments[0].layers[3];
  fs::resize_file(options_.output / file.path, file.bytes - 1);
  const auto report = verify(options_.output);
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->faults.empty());
}

TEST(ReelLayers, count_the_layer_of_scalar_fields_as_the_finest) {
  Manifest manifest;
  manifest.codec = "octree";
  manifest.depth_max = 10;
  manifest.layer_names = {"base", "middle", "full"};
  EXPECT_THAT(levels_of(manifest), ElementsAre(7, 9, kWholeFrame));
  manifest.scalars = {{"a", 0, 1, false}};
  manifest.layer_names.push_back("scalars");
  EXPECT_THAT(levels_of(manifest), ElementsAre(7, 9, kWholeFrame - 1, kWholeFrame));
  PrepareOptions options;
  EXPECT_EQ(wanted_layers(manifest, options).layers.end, 3u);
  options.scalar.field = "a";
  EXPECT_EQ(wanted_layers(manifest, options).layers.end, 4u);
}

}  // namespace
}  // namespace pointreel::scalar_package_test
