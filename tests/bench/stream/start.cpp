#include "tests/bench/stream/start.h"

#include <fmt/format.h>

#include "tests/bench/stream/reels.h"
#include "tests/bench/stream/time_json.h"
#include "tests/bench/stream/watching.h"

namespace pointreel::bench {

using nlohmann::json;

Result<json> run_start(const StreamOptions& options, std::vector<Bar>& bars) {
  const auto served = ServedReels::start(options);
  if (!served) return tl::unexpected(served.error());
  json rows = json::array();
  for (const StreamedReel& reel : (*served)->reels()) {
    for (const auto& [named, limit] :
         {std::pair{megabits(50), 500.0}, std::pair{megabits(5), 1500.0}}) {
      const auto link = (*served)->link(named);
      if (!link) return tl::unexpected(link.error());
      TimeSamples first, whole;
      for (int run = 0; run < (options.quick ? 3 : 20); ++run) {
        const double begin = now_ms();
        auto watching = Watching::start(ServedReels::url(**link, reel), {});
        if (!watching) return tl::unexpected(watching.error());
        if (!(*watching)->until([](const auto& update) { return update.frame != nullptr; }))
          return fail(reel.name + ": no picture");
        first.add(now_ms() - begin);
        const bool fine = (*watching)->until(
            [](const auto& update) { return update.frame->level == kWholeFrame; },
            std::chrono::seconds(3));
        if (fine) whole.add(now_ms() - begin);
      }
      bars.push_back({fmt::format("start, {}, {}: first picture, 95 %", reel.name, named.name),
                      first.summary().p95, "ms", limit});
      rows.push_back({{"reel", reel.name},
                      {"link", named.name},
                      {"first_picture_ms", json_of(first)},
                      {"first_whole_picture_ms", json_of(whole)}});
    }
  }
  return json{{"rows", rows}};
}

}  // namespace pointreel::bench
