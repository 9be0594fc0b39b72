#include "tests/bench/stream/rate_change.h"

#include <algorithm>
#include <map>
#include <thread>

#include <fmt/format.h>

#include "common/base/try.h"
#include "tests/bench/stream/reels.h"
#include "tests/bench/stream/watching.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

/// The figures of one phase, in which the link keeps its rate.
struct Phase {
  std::uint64_t megabits = 0;
  double seconds = 0.0;
  struct At {
    double seconds;
    LayerDecision decision;
  };
  std::vector<At> decisions;                     ///< all changes since the phase began
  std::map<std::uint32_t, std::uint64_t> shown;  ///< number of pictures by number of layers
  std::uint64_t pictures = 0;
  double stalled = 0.0, longest_stall = 0.0, link_mbit = 0.0;

  /// The decision that was kept for the longest time in total.
  LayerDecision usual() const {
    LayerDecision best;
    double most = -1.0;
    for (const At& one : decisions) {
      double kept = 0.0;
      for (std::size_t i = 0; i < decisions.size(); ++i)
        if (decisions[i].decision == one.decision) kept += kept_for(i);
      if (kept > most) {
        most = kept;
        best = one.decision;
      }
    }
    return best;
  }
  /// The time when that decision was first made and then kept for a second or more.
  double settled() const {
    for (std::size_t i = 0; i < decisions.size(); ++i)
      if (decisions[i].decision == usual() && kept_for(i) >= 1.0) return decisions[i].seconds;
    return seconds;
  }
  double kept_for(std::size_t i) const {
    return (i + 1 < decisions.size() ? decisions[i + 1].seconds : seconds) - decisions[i].seconds;
  }
};

Phase play_phase(Watching& watching, std::uint64_t megabits, double seconds) {
  Phase phase;
  phase.megabits = megabits;
  phase.seconds = seconds;
  ReelPlayback& playback = watching.playback();
  const auto before = playback.statistics();
  const double begin = now_ms();
  std::shared_ptr<const SceneFrame> last;
  double last_ms = begin, longest_gap = 0.0;
  while (now_ms() - begin < seconds * 1000.0) {
    const auto update = playback.update(Clock::TimePoint::clock::now());
    const double at = (now_ms() - begin) / 1000.0;
    const LayerDecision decision = playback.decision();
    if (phase.decisions.empty() || phase.decisions.back().decision != decision)
      phase.decisions.push_back({at, decision});
    if (update.frame && (!last || update.frame->index != last->index)) {
      longest_gap = std::max(longest_gap, now_ms() - last_ms);
      last_ms = now_ms();
      last = update.frame;
      ++phase.shown[update.frame->layers];
      ++phase.pictures;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  longest_gap = std::max(longest_gap, now_ms() - last_ms);
  const auto after = playback.statistics();
  phase.stalled = after.stalled_seconds - before.stalled_seconds;
  phase.longest_stall = longest_gap / 1000.0;
  phase.link_mbit = after.link_bits_per_second / 1e6;
  return phase;
}

json json_of(const LayerDecision& decision) {
  return {{"layers", decision.layers.end},
          {"normals", decision.layers.normals},
          {"limited_by", name(decision.limit)}};
}

json json_of(const Phase& phase) {
  json shown = json::object(), decisions = json::array();
  for (const auto& [layers, pictures] : phase.shown) shown[std::to_string(layers)] = pictures;
  for (const Phase::At& at : phase.decisions) {
    json one = json_of(at.decision);
    one["seconds"] = at.seconds;
    decisions.push_back(std::move(one));
  }
  return {{"mbit_per_second", phase.megabits},
          {"settled_seconds", phase.settled()},
          {"settled_at", json_of(phase.usual())},
          {"stalled_seconds", phase.stalled},
          {"longest_without_a_new_picture_seconds", phase.longest_stall},
          {"measured_mbit_per_second", phase.link_mbit},
          {"pictures", phase.pictures},
          {"pictures_by_layers", shown},
          {"decisions", decisions}};
}

}  // namespace

Result<json> run_rate_change(const StreamOptions& options, std::vector<Bar>& bars) {
  const auto served = TRY(ServedReels::start(options));
  json rows = json::array();
  for (const StreamedReel& reel : served->reels()) {
    const auto link = TRY(served->link(megabits(100)));
    const auto watching = TRY(Watching::start(ServedReels::url(*link, reel), {}));
    watching->until([](const auto& update) { return update.frame != nullptr; });
    json phases = json::array();
    double longest = 0.0;
    bool first = true;
    for (const std::uint64_t rate : {100, 5, 100}) {
      link->set(megabits(rate).conditions);
      const Phase phase = play_phase(*watching, rate, options.quick ? 5.0 : 10.0);
      // The first phase does not count, because it includes the start of playback.
      if (!first) {
        longest = std::max(longest, phase.longest_stall);
        bars.push_back(
            {fmt::format("rate change, {}, to {} Mbit/s: time to settle", reel.name, rate),
             phase.settled(), "s", 2.0});
      }
      first = false;
      phases.push_back(json_of(phase));
    }
    bars.push_back({fmt::format("rate change, {}: longest time without a new picture", reel.name),
                    1000.0 * longest, "ms", 200.0});
    rows.push_back({{"reel", reel.name},
                    {"all_layers_mbit_per_second", reel.bits_per_second / 1e6},
                    {"phases", phases}});
  }
  return json{{"rows", rows}};
}

}  // namespace pointreel::bench
