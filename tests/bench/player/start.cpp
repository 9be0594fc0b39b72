#include <fmt/format.h>

#include "common/base/try.h"
#include "tests/bench/player/player_chapters.h"
#include "tests/bench/player/watched_window.h"
#include "tests/bench/stream/reels.h"
#include "tests/bench/stream/time_json.h"

namespace pointreel::bench {

using nlohmann::json;

Result<json> run_player_start(const StreamOptions& options, std::vector<Bar>& bars) {
  const auto reels = TRY(streamed_reels(options));
  json rows = json::array();
  for (const StreamedReel& reel : reels) {
    TimeSamples window, first;
    double differing = 0.0;
    const int runs = options.quick ? 3 : 20;
    for (int run = 0; run < runs; ++run) {
      WatchedWindow watched = TRY(WatchedWindow::open(options, {reel.folder.string()}));
      if (!watched.wait_for_picture())
        return fail(ErrorCode::io, reel.name + ": the window shows no picture");
      if (run == 0) {
        watched.player->key("Home");
        watched.player->key("space");
        watched.player->key("Home");
        differing = TRY(watched.differing_share(reel.folder.string(), 0.0, options));
      }
      const json report = TRY(watched.quit());
      window.add(report["window"]["window_ms"]);
      first.add(report["window"]["first_picture_ms"]);
    }
    bars.push_back(
        {fmt::format("start, {}: window, 95 %", reel.name), window.summary().p95, "ms", 300.0});
    bars.push_back({fmt::format("start, {}: first picture, 95 %", reel.name), first.summary().p95,
                    "ms", 600.0});
    bars.push_back(
        {fmt::format("start, {}: pixels that differ from those without a window", reel.name),
         100.0 * differing, "%", 0.0});
    rows.push_back({{"reel", reel.name},
                    {"runs", runs},
                    {"window_ms", json_of(window)},
                    {"first_picture_ms", json_of(first)},
                    {"pixels_unlike_offscreen", differing}});
  }
  return json{{"rows", rows}};
}

}  // namespace pointreel::bench
