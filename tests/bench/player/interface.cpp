#include <chrono>
#include <thread>

#include <fmt/format.h>

#include "common/base/try.h"
#include "tests/bench/player/player_chapters.h"
#include "tests/bench/player/watched_window.h"
#include "tests/bench/stream/reels.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

struct Case {
  std::string name;
  std::vector<std::string> keys;
  bool on_timeline;  ///< the mouse moves on the timeline, which shows thumbnails
  double scale;
};

}  // namespace

Result<json> run_player_interface(const StreamOptions& options, std::vector<Bar>& bars) {
  const auto reels = TRY(streamed_reels(options));
  const StreamedReel& reel = reels.front();
  const std::vector<Case> cases = {
      {"bar", {}, false, 1.0},
      {"bar and thumbnails", {}, true, 1.0},
      {"bar and both panels", {"d", "i"}, false, 1.0},
      {"bar and help", {"question"}, false, 1.0},
      {"bar and both panels, double size", {"d", "i"}, false, 2.0},
  };
  json rows = json::array();
  for (const Case& each : cases) {
    WatchedWindow watched =
        TRY(WatchedWindow::open(options, {reel.folder.string(), "--mode", "point", "--ui-scale",
                                          fmt::format("{}", each.scale)}));
    if (!watched.wait_for_picture())
      return fail(ErrorCode::io, reel.name + ": the window shows no picture");
    for (const std::string& key : each.keys) watched.player->key(key);
    const glm::ivec2 size = watched.player->size();
    const double begin = now_ms();
    for (int i = 0; now_ms() - begin < (options.quick ? 2000.0 : 10'000.0); ++i) {
      const int y = each.on_timeline ? size.y - static_cast<int>(45.0 * each.scale) : size.y / 2;
      watched.player->move_to({size.x / 4 + (i * 17) % (size.x / 2), y});
      std::this_thread::sleep_for(std::chrono::milliseconds(30));
    }
    const json report = TRY(watched.quit());
    const json& times = report["window"]["interface_ms"];
    bars.push_back({fmt::format("interface, {}: time per picture, median", each.name),
                    times["median"], "ms", 3.0});
    rows.push_back({{"shown", each.name},
                    {"interface_ms", times},
                    {"render_ms", report["render_ms"]},
                    {"frames_shown", report["frames_shown"]},
                    {"frames_dropped", report["frames_dropped"]}});
  }
  return json{{"rows", rows}};
}

}  // namespace pointreel::bench
