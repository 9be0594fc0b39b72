#include <chrono>
#include <cmath>
#include <random>
#include <thread>

#include <fmt/format.h>

#include "tests/bench/player/player_chapters.h"
#include "tests/bench/player/watched_window.h"
#include "tests/bench/stream/reels.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

constexpr double kFrameMs = 1000.0 / 30.0;  ///< of streamed_reels

/// A pixel of the timeline, which has 14 beside it.
glm::ivec2 on_timeline(glm::ivec2 size, double share) {
  return {static_cast<int>(std::lround(14.0 + share * (size.x - 28.0))), size.y - 45};
}

/// Which frame a pixel of it stands for.
std::uint32_t frame_at(int x, glm::ivec2 size, std::uint32_t frames) {
  return static_cast<std::uint32_t>((x - 14.0) / (size.x - 28.0) * frames);
}

}  // namespace

Result<json> run_player_scrub(const StreamOptions& options, std::vector<Bar>& bars) {
  const auto served = ServedReels::start(options);
  if (!served) return tl::unexpected(served.error());
  std::mt19937_64 random(7);
  json rows = json::array();
  for (const StreamedReel& reel : (*served)->reels()) {
    for (const bool local : {true, false}) {
      const NamedLink named = local ? NamedLink{"folder", {}} : megabits(50);
      const auto link = (*served)->link(named);
      if (!link) return tl::unexpected(link.error());
      const std::string where = local ? reel.folder.string() : ServedReels::url(**link, reel);
      auto watched = WatchedWindow::open(options, {where});
      if (!watched) return tl::unexpected(watched.error());
      if (!watched->wait_for_picture()) return fail(reel.name + ": no picture");
      window::PlayerWindow& player = *watched->player;
      const glm::ivec2 size = player.size();
      player.key("space");
      player.press(on_timeline(size, 0.5));
      const int moves = options.quick ? 40 : 300;
      glm::ivec2 last{0};
      for (int move = 0; move < moves; ++move) {
        // As a hand does: mostly on, a little or much, and now and then far away.
        const double share = static_cast<double>(random() % 10'000) / 10'000.0;
        last = on_timeline(size, share);
        player.move_to(last);
        std::this_thread::sleep_for(std::chrono::milliseconds(options.quick ? 60 : 120));
      }
      // What was asked for last is shown before the hand lets go.
      watched->wait_until_settled();
      player.release();
      player.move_to(size / 3);  // or a small picture would stand over the timeline
      const std::uint32_t frame = frame_at(last.x, size, reel.frames);
      // The frame's middle, so that nothing rounds to its neighbour.
      const auto share = watched->differing_share(reel.folder.string(),
                                                  (frame + 0.5) * kFrameMs / 1000.0, options);
      if (!share) return tl::unexpected(share.error());
      const auto report = watched->quit();
      if (!report) return tl::unexpected(report.error());
      const json& times = (*report)["window"]["scrub_to_picture_ms"];
      const double fetch = (*report)["fetch_ms"]["median"];
      bars.push_back({fmt::format("scrub, {}, {}: move to picture, 95 %", reel.name, named.name),
                      times["p95"], "ms", kFrameMs + fetch});
      bars.push_back(
          {fmt::format("scrub, {}, {}: frame shown in the end, off by", reel.name, named.name),
           std::abs((*report)["window"]["frame"].get<double>() - frame), "", 0.0});
      bars.push_back({fmt::format("scrub, {}, {}: pixels unlike those without a window", reel.name,
                                  named.name),
                      100.0 * *share, "%", 0.0});
      rows.push_back({{"reel", reel.name},
                      {"from", named.name},
                      {"moves", moves},
                      {"scrub_to_picture_ms", times},
                      {"frame_ms", kFrameMs},
                      {"fetch_ms", (*report)["fetch_ms"]},
                      {"decode_ms", (*report)["decode_ms"]},
                      {"render_ms", (*report)["render_ms"]},
                      {"pixels_unlike_offscreen", *share}});
    }
  }
  return json{{"rows", rows}};
}

}  // namespace pointreel::bench
