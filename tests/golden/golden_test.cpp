// Tests the streams of tests/golden/streams. README.md describes them.
//
//   pointreel_golden               tests them
//   pointreel_golden --portable    tests them with the portable code, as on a processor without
//   BMI2 pointreel_golden --make DIR    writes the streams that today's encoders make, and their
//   outcomes

#include <fstream>
#include <iterator>
#include <map>
#include <string_view>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pointreel/chunks.h"
#include "pointreel/cpu.h"
#include "pointreel/draco.h"
#include "pointreel/octree.h"
#include "tests/forge.h"
#include "tests/golden/streams.h"
#include "tests/paths.h"
#include "tests/reference/frame_decoder.h"

namespace pointreel::golden::golden_test {
namespace {

const std::filesystem::path kFolder = source_folder() / "tests/golden/streams";

Bytes read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  EXPECT_TRUE(in) << file;
  return Bytes(std::istreambuf_iterator<char>(in), {});
}

/// The frame of every file in the folder, by name.
std::map<std::string, EncodedFrame> stored_frames() {
  std::map<std::string, EncodedFrame> frames;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder)) {
    if (entry.path().extension() != ".frame") continue;
    auto frame = frame_of(read(entry.path()));
    EXPECT_TRUE(frame) << entry.path();
    if (frame) frames[entry.path().stem()] = std::move(*frame);
  }
  return frames;
}

nlohmann::json stored_outcomes() {
  return nlohmann::json::parse(std::ifstream(kFolder / "outcomes.json"), nullptr, false);
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

}  // namespace
}  // namespace pointreel::golden::golden_test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const std::string_view option = argc > 1 ? argv[1] : "";
  if (option == "--make" && argc > 2) {
    const auto written = pointreel::golden::write_streams(argv[2]);
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
