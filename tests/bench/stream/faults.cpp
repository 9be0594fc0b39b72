#include "tests/bench/stream/faults.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "common/base/try.h"
#include "tests/fault/live_stage.h"
#include "tests/fault/served_reel.h"
#include "tests/fault/watcher.h"
#include "tests/link/link_emulator.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;
using Time = std::chrono::steady_clock::time_point;

/// A fault of a link or a server. `happen` returns when the link works again.
struct Fault {
  const char* name;
  std::function<void()> happen;
};

/// Everything between a server and a watcher.
struct FaultStage {
  std::filesystem::path reel;
  std::vector<std::string> options;
  std::unique_ptr<ServerProcess> server;
  std::unique_ptr<LinkEmulator> link;
  LinkConditions conditions;

  Result<void> begin() {
    server = std::make_unique<ServerProcess>(reel, 0, options);
    if (server->port() == 0) return fail(ErrorCode::io, "pointreel-server: did not start");
    link = TRY(LinkEmulator::start({.target = server->address(), .conditions = conditions}));
    return {};
  }

  std::vector<Fault> faults(bool quick) {
    const auto down = quick ? 3s : 10s;
    return {{"server killed",
             [=, this] {
               const int port = server->port();
               server->kill();
               std::this_thread::sleep_for(down);
               server = std::make_unique<ServerProcess>(reel, port, options);
             }},
            {"link cut",
             [=, this] {
               LinkConditions cut = conditions;
               cut.cut = true;
               link->set(cut);
               std::this_thread::sleep_for(down);
               link->set(conditions);
             }},
            {"connections reset", [this] { link->reset_connections(); }},
            {"connections forgotten", [this] { link->forget_connections(); }}};
  }
};

double milliseconds(Time::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

/// The time from `back` to the first picture that `counts` accepts; at most a minute.
template <class Watcher, class Counts>
double recovery_ms(const Watcher& watcher, Time back, const Counts& counts) {
  for (const Time end = back + 60s; std::chrono::steady_clock::now() < end;) {
    const auto shown = watcher.shown();
    const auto first = std::find_if(shown.begin(), shown.end(), [&](const auto& each) {
      return each.at > back && counts(each);
    });
    if (first != shown.end()) return milliseconds(first->at - back);
    std::this_thread::sleep_for(2ms);
  }
  return 60'000.0;
}

template <class Watcher>
std::size_t wrong_pictures(const Watcher& watcher) {
  const auto shown = watcher.shown();
  return static_cast<std::size_t>(
      std::count_if(shown.begin(), shown.end(), [](const auto& each) { return !each.right; }));
}

}  // namespace

Result<json> run_faults(const StreamOptions& options, std::vector<Bar>& bars) {
  const std::filesystem::path reel = options.scratch / "ball";
  const double rate = TRY(make_ball_reel(reel));
  const auto truth = TRY(truth_of(reel));

  json package, live;
  std::size_t wrong = 0, pictures = 0;
  double worst_package = 0.0, worst_live = 0.0;
  {
    // The link is hardly faster than the reel, so that a player cannot fetch much in advance.
    FaultStage stage{reel, {}, nullptr, nullptr, {}};
    stage.conditions.bits_per_second = static_cast<std::uint64_t>(1.5 * rate);
    stage.conditions.delay = 10ms;
    TRY(stage.begin());
    for (const Fault& fault : stage.faults(options.quick)) {
      Watcher watcher("http://" + stage.link->address() + "/ball", truth);
      if (!watcher.sees(30)) return fail(watcher.trouble().value_or("nothing was played"));
      fault.happen();
      const Time back = std::chrono::steady_clock::now();
      const double ms = recovery_ms(watcher, back, [](const auto&) { return true; });
      package[fault.name] = ms;
      worst_package = std::max(worst_package, ms);
      wrong += wrong_pictures(watcher);
      pictures += watcher.shown().size();
    }
  }
  {
    FaultStage stage{reel, {"--live"}, nullptr, nullptr, {}};
    stage.conditions.delay = 10ms;
    TRY(stage.begin());
    const StagePublisher publisher("ws://" + stage.server->address() + "/live/ball?publish");
    for (const Fault& fault : stage.faults(options.quick)) {
      LiveWatcher watcher("ws://" + stage.link->address() + "/live/ball");
      if (!watcher.sees(30)) return fail(watcher.trouble().value_or("nothing came"));
      fault.happen();
      const Time back = std::chrono::steady_clock::now();
      const std::uint64_t newest = publisher.newest_us();
      const double ms =
          recovery_ms(watcher, back, [=](const auto& each) { return each.capture_us >= newest; });
      live[fault.name] = ms;
      worst_live = std::max(worst_live, ms);
      wrong += wrong_pictures(watcher);
      pictures += watcher.shown().size();
    }
  }
  bars.push_back(
      {"package: from a working link to a picture, worst fault", worst_package, "ms", 2000});
  bars.push_back({"live: from a working link to live, worst fault", worst_live, "ms", 2000});
  bars.push_back(
      {"wrong pictures during faults of links and servers", static_cast<double>(wrong), "", 0.0});
  return json{{"package_ms", package}, {"live_ms", live}, {"pictures", pictures}, {"wrong", wrong}};
}

}  // namespace pointreel::bench
