// Tests the streams of tests/golden/streams. README.md describes them.
//
//   pointreel_golden             tests them
//   pointreel_golden --portable  the same with the portable code, as on a processor without BMI2
//   pointreel_golden --make DIR  writes what today's encoders make, and its outcomes: the videos if
//                                DIR is a folder of that name, else the streams

#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <string_view>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/video/video_decoder.h"
#include "pointreel/chunks.h"
#include "pointreel/cpu.h"
#include "pointreel/draco.h"
#include "pointreel/octree.h"
#include "tests/forge.h"
#include "tests/golden/streams.h"
#include "tests/golden/videos.h"
#include "tests/paths.h"
#include "tests/reference/frame_decoder.h"
#include "tests/reference/video_decoder.h"

namespace pointreel::golden::golden_test {
namespace {

const std::filesystem::path kFolder = source_folder() / "tests/golden/streams";
const std::filesystem::path kVideos = source_folder() / "tests/golden/videos";

Bytes read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  EXPECT_TRUE(in) << file;
  return Bytes(std::istreambuf_iterator<char>(in), {});
}

/// What is in every file of a folder with this ending, by its name.
std::map<std::string, EncodedFrame> stored_frames(const std::filesystem::path& folder = kFolder,
                                                  const char* ending = ".frame") {
  std::map<std::string, EncodedFrame> frames;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ending) continue;
    auto frame = frame_of(read(entry.path()));
    EXPECT_TRUE(frame) << entry.path();
    if (frame) frames[entry.path().stem()] = std::move(*frame);
  }
  return frames;
}

nlohmann::json stored_outcomes(const std::filesystem::path& folder = kFolder) {
  return nlohmann::json::parse(std::ifstream(folder / "outcomes.json"), nullptr, false);
}

TEST(Golden, every_stream_decodes_to_what_it_must_or_gives_its_error) {
  const auto frames = stored_frames();
  const nlohmann::json outcomes = stored_outcomes();
  ASSERT_GT(frames.size(), 100u);
  EXPECT_EQ(outcomes.size(), frames.size());
  for (const auto& [name, frame] : frames) {
    ASSERT_TRUE(outcomes.contains(name)) << name;
    EXPECT_EQ(outcome(frame), outcomes[name]) << name;
  }
}

TEST(Golden, every_video_decodes_to_what_it_must_or_gives_its_error) {
  const auto groups = stored_frames(kVideos, ".group");
  const nlohmann::json outcomes = stored_outcomes(kVideos);
  EXPECT_EQ(outcomes.size(), groups.size());
  EXPECT_GE(groups.size(), 8u);
  for (const auto& [name, group] : groups) {
    ASSERT_TRUE(outcomes.contains(name)) << name;
    EXPECT_EQ(video_outcome(group), outcomes[name]) << name;
    EXPECT_EQ(outcomes[name].back().contains("error"), name.starts_with("bad_")) << name;
  }
}

TEST(Golden, the_encoders_still_make_the_same_bytes) {
  for (const auto make : {good_streams, changed_streams}) {
    const auto streams = make();
    ASSERT_TRUE(streams) << streams.error().message;
    for (const Stream& stream : *streams) {
      EXPECT_EQ(file_of(stream.frame), read(kFolder / (stream.name + ".frame"))) << stream.name;
    }
  }
}

TEST(Golden, the_decoder_written_from_the_format_s_description_agrees_on_every_octree) {
  const reference::Tables tables =
      reference::read_tables(read(source_folder() / "codec/octree/tables/1.zst"));
  for (const auto& [name, frame] : stored_frames()) {
    if (name.find("draco") != std::string::npos) continue;
    // A bad frame is decoded as a whole; of other frames, every prefix is decoded.
    const std::size_t least = name.starts_with("bad_") ? frame.layers.size() : 1;
    for (std::size_t layers = least; layers <= frame.layers.size(); ++layers) {
      auto views = layer_views(frame.layers);
      views.resize(layers);
      const auto expected = reference::decode_frame(views, tables);
      const auto decoded = decode_frame(views);
      ASSERT_EQ(decoded.has_value(), expected.has_value())
          << name << ", " << layers
          << " layers: " << (decoded ? expected.error().message : decoded.error().message);
      if (!decoded) continue;
      EXPECT_EQ(leaf_cells(*decoded->svo), expected->cells) << name;
      EXPECT_EQ(decoded->svo->depth, expected->depth) << name;
      EXPECT_EQ(decoded->cloud.colors, expected->colors) << name;
      ASSERT_EQ(decoded->cloud.scalars.size(), expected->scalars.size()) << name;
      for (std::size_t f = 0; f < expected->scalars.size(); ++f) {
        EXPECT_EQ(decoded->cloud.scalars[f].name, expected->scalars[f].name) << name;
        EXPECT_THAT(decoded->cloud.scalars[f].values,
                    testing::Pointwise(testing::NanSensitiveFloatEq(), expected->scalars[f].values))
            << name;
      }
      ASSERT_EQ(decoded->cloud.normals.size(), expected->normals.size()) << name;
      for (std::size_t i = 0; i < expected->normals.size(); ++i) {
        const glm::dvec3 error = glm::dvec3(decoded->cloud.normals[i]) - expected->normals[i];
        ASSERT_LT(glm::length(error), 1e-6) << name;
      }
      const double cell = expected->edge / static_cast<double>(1 << expected->depth);
      for (std::size_t i = 0; i < expected->cells.size(); ++i) {
        const glm::dvec3 centre = expected->corner + (glm::dvec3(expected->cells[i]) + 0.5) * cell;
        ASSERT_LT(glm::length(decoded->cloud.world(i) - centre), 1e-6 * expected->edge) << name;
      }
    }
  }
}

/// The largest extent of points along an axis.
double extent_of(const std::vector<glm::dvec3>& places) {
  glm::dvec3 least(std::numeric_limits<double>::max()), most = -least;
  for (const glm::dvec3& place : places) {
    least = glm::min(least, place);
    most = glm::max(most, place);
  }
  const glm::dvec3 extent = most - least;
  return std::max({extent.x, extent.y, extent.z});
}

/// Compares the points of a frame of video in their order.
void expect_same_points(const PointCloud& cloud, const reference::VideoPoints& expected) {
  ASSERT_EQ(cloud.size(), expected.positions.size());
  ASSERT_EQ(cloud.normals.size(), expected.normals.size());
  EXPECT_EQ(cloud.colors, expected.colors);
  const double near = 1e-6 * extent_of(expected.positions);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    ASSERT_LT(glm::length(cloud.world(i) - expected.positions[i]), near) << i;
    ASSERT_LT(glm::length(glm::dvec3(cloud.normals[i]) - expected.normals[i]), 1e-5) << i;
  }
}

TEST(Golden, the_video_decoder_written_from_the_format_s_description_agrees) {
  const reference::Tables tables =
      reference::read_tables(read(source_folder() / "codec/octree/tables/1.zst"));
  for (const auto& [name, group] : stored_frames(kVideos, ".group")) {
    VideoDecoder decoder;
    reference::VideoDecoder expected_decoder(tables);
    for (const Chunks<ByteView>& chunks : layer_views(group.layers)) {
      const auto expected = expected_decoder.next(chunks);
      const auto pictures = decoder.next(chunks);
      const auto decoded = pictures.and_then([](const auto& shown) { return points_of(shown); });
      ASSERT_EQ(decoded.has_value(), expected.has_value())
          << name << ": " << (decoded ? expected.error().message : decoded.error().message);
      if (!decoded) break;
      SCOPED_TRACE(name);
      expect_same_points(*decoded, *expected);
    }
  }
}

}  // namespace
}  // namespace pointreel::golden::golden_test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const std::string_view option = argc > 1 ? argv[1] : "";
  if (option == "--make" && argc > 2) {
    const std::filesystem::path folder = argv[2];
    const bool videos = folder.filename() == "videos";
    const auto written =
        videos ? pointreel::golden::write_videos(folder) : pointreel::golden::write_streams(folder);
    if (!written) fmt::print(stderr, "pointreel_golden: {}\n", written.error().message);
    return written ? 0 : 1;
  }
  if (option == "--portable") {
    // The reference decoder has only portable code, so its test is left out.
    testing::GTEST_FLAG(filter) = "Golden.every_*:Golden.the_encoders_*";
    pointreel::set_cpu_feature_mask(0);
  }
  return RUN_ALL_TESTS();
}
