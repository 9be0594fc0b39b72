#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/session/report.h"

namespace pointreel::play_report_test {
namespace {

Manifest reel() {
  Manifest manifest;
  manifest.codec = "octree";
  manifest.depth_max = 10;
  Segment segment;
  segment.times_us = {0, 40'000};
  segment.layers.resize(3);
  for (LayerFile& file : segment.layers) file.frames = {{100, 20, 3}, {1000, 200, 30}};
  segment.layers[2].frames[0] = {0, 0, 0};  // the first frame is shallower
  manifest.segments.push_back(segment);
  return manifest;
}

SceneFrame frame_of(std::uint32_t index, std::uint32_t layers) {
  SceneFrame frame;
  frame.index = index;
  frame.layers = layers;
  frame.svo.depth = 9;
  frame.svo.level_begin.assign(11, 0);
  return frame;
}

TEST(NotFetched, counts_layers_attributes_and_bytes_that_a_frame_did_not_need) {
  const Manifest manifest = reel();
  NotFetched rest = not_fetched(manifest, frame_of(1, 2), {0, 2, true, false});
  EXPECT_EQ(rest.layers, 1u);
  EXPECT_FALSE(rest.colors);
  EXPECT_TRUE(rest.normals);
  EXPECT_EQ(rest.bytes, 1230u + 2 * 30u);
  rest = not_fetched(manifest, frame_of(1, 1), {0, 1, false, false});
  EXPECT_EQ(rest.layers, 2u);
  EXPECT_TRUE(rest.colors && rest.normals);
  EXPECT_EQ(rest.bytes, 3 * 1230u - 1000u);
  rest = not_fetched(manifest, frame_of(0, 2), {});
  EXPECT_EQ(rest.layers, 0u) << "it has no third layer";
  EXPECT_EQ(rest.bytes, 0u);
  rest = not_fetched(manifest, frame_of(0, 0), {});
  EXPECT_EQ(rest.bytes, 0u) << "a file is read as a whole";
}

TEST(PlayReport, states_what_was_skipped_in_all_frames_and_not_drawn_of_the_last) {
  const Manifest manifest = reel();
  PlayReport report;
  report.finest_level = 10;
  const SceneFrame first = frame_of(0, 1), second = frame_of(1, 1);
  DrawStats drawn;
  report.add(first, not_fetched(manifest, first, {}), drawn);
  drawn.coarsening.reduction = 2;
  report.add(second, not_fetched(manifest, second, {}), drawn);
  auto json = nlohmann::json::parse(report.to_json());
  EXPECT_EQ(json["frames_shown"], 2);
  EXPECT_EQ(json["frames_reduced"], 1);
  EXPECT_EQ(json["skipped"]["bytes"], 123 + 2460);
  EXPECT_EQ(json["skipped"]["layers"], 2);
  EXPECT_EQ(json["skipped"]["levels"], 1);

  // The second frame comes again, with two layers and without its normals.
  const SceneFrame again = frame_of(1, 2);
  drawn.out_of_view = 7;
  drawn.below_pixel = 5;
  drawn.hidden = 3;
  report.add_refined(again, not_fetched(manifest, again, {0, 2, true, false}), drawn);
  json = nlohmann::json::parse(report.to_json());
  EXPECT_EQ(json["frames_shown"], 2);
  EXPECT_EQ(json["frames_refined"], 1);
  EXPECT_EQ(json["layers"], 2);
  EXPECT_EQ(json["skipped"]["bytes"], 123 + 1230 + 60);
  EXPECT_EQ(json["skipped"]["attributes"], nlohmann::json::array({"normals"}));
  EXPECT_EQ(json["skipped"]["out_of_view"], 7);
  EXPECT_EQ(json["skipped"]["below_pixel"], 5);
  EXPECT_EQ(json["skipped"]["hidden"], 3);
}

TEST(PlayReport, counts_the_bytes_of_reels_and_of_live_streams) {
  PlayReport report;
  report.sources.resize(2);
  report.sources[0].reel.emplace().fetched_bytes = 1353;
  report.sources[0].reel->reused = 17;
  report.sources[1].live.emplace().bytes = 2400;
  const auto json = nlohmann::json::parse(report.to_json());
  EXPECT_EQ(json["sources"][0]["fetched_bytes"], 1353);
  EXPECT_EQ(json["sources"][0]["frames_from_cache"], 17);
  EXPECT_EQ(json["fetched_bytes"], 1353 + 2400);
}

TEST(PlayReport, lists_the_chosen_layers_of_frames_and_the_reasons) {
  PlayReport report;
  SourceReport source;
  source.reel.emplace();
  source.reel->stalls = 2;
  source.chosen = {{0, {{0, 1, true, false}, Limit::link}},
                   {30, {{0, 3, true, true}, Limit::none}}};
  report.sources.push_back(source);
  const auto json = nlohmann::json::parse(report.to_json())["sources"][0];
  EXPECT_EQ(json["stalls"]["count"], 2);
  EXPECT_EQ(json["chosen"][0]["layers"], 1);
  EXPECT_EQ(json["chosen"][0]["attributes"], nlohmann::json::array({"colors"}));
  EXPECT_EQ(json["chosen"][0]["limited_by"], "link");
  EXPECT_EQ(json["chosen"][1]["from_frame"], 30);
  EXPECT_EQ(json["chosen"][1]["limited_by"], "nothing");
}

}  // namespace
}  // namespace pointreel::play_report_test
