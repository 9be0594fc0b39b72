#include "tests/bench/scale/edges.h"

#include <fstream>

#include <gtest/gtest.h>

#include "tests/bench/scale/lru_cache.h"
#include "tests/bench/scale/request_log.h"
#include "tests/temporary_folder.h"

namespace pointreel::bench::edges_test {
namespace {

/// Two layers of 100 and 300 bytes a frame, 10 frames a second, in 36 segments of one second.
const PlannedReel kReel{0.01, 1.0, 10.0, {100.0, 300.0}};
/// Three seconds at 10 frames a second: all of the base, and one frame of the next layer.
Trace trace() {
  Trace requests;
  for (std::uint32_t frame = 0; frame < 30; ++frame)
    requests.push_back({0.1 * frame + 0.05, frame / 10, 0, 77});
  requests.push_back({1.0, 1, 1, 77});
  return requests;
}

EdgeFigures watched_by(std::uint32_t viewers, const EdgeCaches& edges, double seconds = 3.0) {
  const std::vector<Trace> traces = {trace()};
  return simulate(kReel, {viewers, 0.0, seconds, 1.0}, edges, traces, 10.0);
}

TEST(LruCacheTest, drops_what_was_used_longest_ago) {
  LruCache cache(4, 20);
  EXPECT_FALSE(cache.use(0, 10));
  EXPECT_FALSE(cache.use(1, 10));
  EXPECT_TRUE(cache.use(0, 10));
  EXPECT_FALSE(cache.use(2, 10));  // drops 1
  EXPECT_TRUE(cache.use(0, 10));
  EXPECT_FALSE(cache.use(1, 10));
}

TEST(LruCacheTest, passes_through_what_is_larger_than_itself) {
  LruCache cache(2, 20);
  EXPECT_FALSE(cache.use(0, 20));
  EXPECT_FALSE(cache.use(1, 21));
  EXPECT_FALSE(cache.use(1, 21));
  EXPECT_TRUE(cache.use(0, 20));
}

TEST(EdgesTest, one_viewer_gets_what_the_trace_asks_for_and_edges_fetch_whole_files) {
  const EdgeFigures figures = watched_by(1, {1, 1'000'000});
  EXPECT_DOUBLE_EQ(figures.requests, 31.0);
  EXPECT_DOUBLE_EQ(figures.bytes, 30 * 100.0 + 300.0);
  EXPECT_DOUBLE_EQ(figures.store_requests, 4.0);
  EXPECT_DOUBLE_EQ(figures.store_bytes, 3 * 1000.0 + 3000.0);
  EXPECT_DOUBLE_EQ(figures.most_requests, 11.0);
}

TEST(EdgesTest, viewers_of_one_edge_share_what_it_fetched) {
  const EdgeFigures one = watched_by(1, {1, 1'000'000}), many = watched_by(100, {1, 1'000'000}),
                    apart = watched_by(100, {10, 1'000'000});
  EXPECT_DOUBLE_EQ(many.bytes, 100.0 * one.bytes);
  EXPECT_DOUBLE_EQ(many.store_bytes, one.store_bytes);
  EXPECT_DOUBLE_EQ(apart.store_bytes, 10.0 * one.store_bytes);
}

TEST(EdgesTest, edges_without_room_fetch_each_time) {
  EXPECT_DOUBLE_EQ(watched_by(2, {1, 1}).store_requests, 2 * watched_by(1, {1, 1}).store_requests);
}

TEST(EdgesTest, longer_sessions_go_on_where_the_trace_ended) {
  const EdgeFigures twice = watched_by(1, {1, 1'000'000}, 6.0);
  EXPECT_DOUBLE_EQ(twice.requests, 62.0);
  EXPECT_DOUBLE_EQ(twice.store_requests, 8.0);  // other segments
}

TEST(RequestLogTest, reads_requests_for_layers_and_skips_other_lines) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.log";
  std::ofstream(file)
      << "listening\n"
         R"({"time":"2026-01-01T23:59:59.500Z","event":"request","target":"/a/reel.json","bytes":9})"
         "\n"
         R"({"time":"2026-01-01T23:59:59.750Z","event":"request","target":"/a/00000.base.0a.prs","bytes":9})"
         "\n"
         R"({"time":"2026-01-02T00:00:00.250Z","event":"request","target":"/a/00030.full.0b.prs","bytes":8})"
         "\n{]\n";
  const auto requests = read_request_log(file);
  ASSERT_TRUE(requests) << requests.error().message;
  ASSERT_EQ(requests->size(), 2u);
  EXPECT_EQ((*requests)[1].segment, 1u);
  EXPECT_EQ((*requests)[1].layer, 2u);
  EXPECT_EQ((*requests)[1].bytes, 8u);
  EXPECT_NEAR((*requests)[1].seconds, 0.5, 1e-9);
}

TEST(RequestLogTest, says_what_a_log_must_be) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.log";
  std::ofstream(file) << "nothing\n";
  const auto requests = read_request_log(file);
  ASSERT_FALSE(requests);
  EXPECT_NE(requests.error().message.find("--log info"), std::string::npos);
}

}  // namespace
}  // namespace pointreel::bench::edges_test
