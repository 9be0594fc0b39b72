#include "client/ui/play_statistics.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/packed_reel.h"
#include "tests/wait.h"

namespace pointreel::play_statistics_test {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

constexpr Clock::TimePoint kStart{std::chrono::hours(5)};

SceneFrame frame(double fetch_ms) {
  SceneFrame frame;
  frame.fetch_ms = fetch_ms;
  frame.decode_ms = 2.0;
  frame.normals_ms = 3.0;
  frame.svo_ms = 4.0;
  return frame;
}

TEST(RecentFrames, keep_the_sorted_times_of_the_latest_frames) {
  RecentFrames recent;
  EXPECT_TRUE(recent.times(Step::fetch).empty());
  DrawStats drawn;
  drawn.cut_ms = 5.0;
  drawn.render_ms = 6.0;
  for (int i = 0; i < 130; ++i) recent.add(frame(i), drawn, kStart);
  const auto fetch = recent.times(Step::fetch);
  ASSERT_EQ(fetch.size(), RecentFrames::kMaxFrames);
  EXPECT_EQ(fetch.front(), 10.0f);
  EXPECT_EQ(fetch.back(), 129.0f);
  EXPECT_TRUE(std::is_sorted(fetch.begin(), fetch.end()));
  EXPECT_EQ(recent.times(Step::decode).back(), 2.0f);
  EXPECT_EQ(recent.times(Step::tree).back(), 7.0f);
  EXPECT_EQ(recent.times(Step::cut).back(), 5.0f);
  EXPECT_EQ(recent.times(Step::draw).back(), 6.0f);
  recent.clear();
  EXPECT_EQ(recent.size(), 0u);
}

TEST(RecentFrames, give_the_rate_over_the_last_two_seconds) {
  RecentFrames recent;
  EXPECT_EQ(recent.frames_per_second(kStart), 0.0);
  for (int i = 0; i < 10; ++i) recent.add(frame(0), {}, kStart + milliseconds(1000 * i));
  auto now = kStart + milliseconds(20'000);
  EXPECT_EQ(recent.frames_per_second(now), 0.0) << "the last frame was shown long ago";
  for (int i = 0; i < 200; ++i) recent.add(frame(0), {}, now += milliseconds(40));
  EXPECT_NEAR(recent.frames_per_second(now), 25.0, 1e-9);
}

TEST(StatisticsText, abbreviates_counts_and_bytes) {
  EXPECT_EQ(short_count(0), "0");
  EXPECT_EQ(short_count(847), "847");
  EXPECT_EQ(short_count(999.9), "1.00 k");
  EXPECT_EQ(short_count(61'000), "61.0 k");
  EXPECT_EQ(short_count(1'234'567), "1.23 M");
  EXPECT_EQ(short_bytes(12), "12 B");
  EXPECT_EQ(short_bytes(1024), "1.00 KiB");
  EXPECT_EQ(short_bytes(std::uint64_t{150} << 20), "150 MiB");
}

class StatisticsLinesTest : public PackTest {
 protected:
  static std::string text_of(const std::vector<StatisticsLine>& lines, const std::string& label) {
    for (const StatisticsLine& line : lines)
      if (line.label == label) return line.text;
    return "there is no such line";
  }
};

TEST_F(StatisticsLinesTest, describe_what_is_shown_and_why) {
  write_frames(3);
  ASSERT_TRUE(pack(layered_options()));
  Stage::Options stage_options;
  stage_options.prepare.layers = 2;
  stage_options.size = glm::ivec2(4000);
  auto stage = Stage::open(
      {{reel_.string()}}, stage_options,
      [](const Box& bounds, Up) {
        Camera camera;
        camera.frame_bounds(bounds, 1.0);
        camera.zoom(0.01);
        return camera;
      },
      [](std::size_t, std::uint32_t, const Error&) {});
  ASSERT_TRUE(stage) << stage.error().message;
  RecentFrames recent;
  EXPECT_THAT(text_of(statistics_lines(**stage, recent, kStart), "Shown"), HasSubstr("0.0"));
  ASSERT_TRUE(wait_until([&] {
    (*stage)->update(kStart);
    const auto& frame = (*stage)->scene()[0].frame;
    return frame && frame->layers >= 2;
  }));
  const auto lines = statistics_lines(**stage, recent, kStart);
  EXPECT_EQ(text_of(lines, "Layers"), "2 of 3: no more were asked for");
  EXPECT_THAT(text_of(lines, "Frame"), testing::StartsWith("201 points, "));
  EXPECT_EQ(text_of(lines, "Dropped"), "0");
  EXPECT_THAT(text_of(lines, "Buffers"), HasSubstr("ready"));
  EXPECT_THAT(text_of(lines, "Memory"), HasSubstr("iB"));

  DrawStats drawn;
  drawn.drawn = 150;
  drawn.coarsening.reduction = 2;
  recent.add(frame(0), drawn, kStart);
  EXPECT_EQ(text_of(statistics_lines(**stage, recent, kStart), "Drawn"),
            "150 elements, 1/2 resolution");
  drawn.coarsening = {1, 1.25f};
  recent.redrawn(drawn);
  EXPECT_EQ(text_of(statistics_lines(**stage, recent, kStart), "Drawn"),
            "150 elements, larger than asked");
  drawn.coarsening = {};
  recent.redrawn(drawn);
  EXPECT_EQ(text_of(statistics_lines(**stage, recent, kStart), "Drawn"), "150 elements");
}

TEST_F(StatisticsLinesTest, name_the_sources_if_there_are_several) {
  write_frames(2);
  auto stage = Stage::open(
      {{frames_.string()}, {frames_.string(), {1.0, 0.0, 0.0}}}, {},
      [](const Box&, Up) { return Camera{}; }, [](std::size_t, std::uint32_t, const Error&) {});
  ASSERT_TRUE(stage) << stage.error().message;
  const auto lines = statistics_lines(**stage, {}, kStart);
  const StatisticsLine source{frames_.filename().string(), ""};
  EXPECT_EQ(std::count(lines.begin(), lines.end(), source), 2);
  EXPECT_EQ(text_of(lines, "Layers"), "none, in files");
}

}  // namespace
}  // namespace pointreel::play_statistics_test
