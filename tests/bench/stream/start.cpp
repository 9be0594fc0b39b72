#include "tests/bench/stream/start.h"

#include <fmt/format.h>

#include "common/base/try.h"
#include "tests/bench/stream/reels.h"
#include "tests/bench/stream/time_json.h"
#include "tests/bench/stream/watching.h"

namespace pointreel::bench {

using nlohmann::json;

Result<json> run_start(const StreamOptions& options, std::vector<Bar>& bars) {
  const auto served = TRY(ServedReels::start(options));
  json rows = json::array();
  for (const StreamedReel& reel : served->reels()) {
    for (const auto& [named, limit] :
         {std::pair{megabits(50), 500.0}, std::pair{megabits(5), 1500.0}}) {
      const auto link = TRY(served->link(named));
      TimeSamples first, whole;
      for (int run = 0; run < (options.quick ? 3 : 20); ++run) {
        const double begin = now_ms();
        const auto watching = TRY(Watching::start(ServedReels::url(*link, reel), {}));
        if (!watching->until([](const auto& update) { return update.frame != nullptr; })) {
          return fail(ErrorCode::io, reel.name + ": no picture came");
        }
        first.add(now_ms() - begin);
        const bool fine =
            watching->until([](const auto& update) { return update.frame->level == kWholeFrame; },
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
