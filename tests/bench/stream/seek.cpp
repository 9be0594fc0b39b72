#include "tests/bench/stream/seek.h"

#include <random>

#include <fmt/format.h>

#include "client/playback/statistics.h"
#include "common/base/try.h"
#include "tests/bench/stream/reels.h"
#include "tests/bench/stream/time_json.h"
#include "tests/bench/stream/watching.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

/// Two seconds are fetched ahead, so nothing has been fetched of frames that are this far away.
constexpr std::uint32_t kFar = 75;

/// A frame that is far from `from` in both directions.
std::uint32_t far_from(std::uint32_t from, std::uint32_t frames, std::mt19937_64& random) {
  return static_cast<std::uint32_t>((from + kFar + random() % (frames - 2 * kFar)) % frames);
}

struct Seeks {
  TimeSamples coarse, exact, dragged, decode;
  std::uint64_t wrong = 0, missing = 0;
};

bool is_right(const StreamedReel& reel, const SceneFrame& frame) {
  const std::uint32_t packed = frame.index % reel.packed_frames;
  // Frames with only some of the enhancement layers are not compared; no layer decodes without
  // those
  // before it.
  if (frame.layers == 1) return content_of(frame) == reel.base[packed];
  return frame.level != kWholeFrame || content_of(frame) == reel.whole[packed];
}

void seek(Watching& watching, const StreamedReel& reel, std::uint64_t count, Seeks& seeks,
          std::mt19937_64& random) {
  ReelPlayback& playback = watching.playback();
  std::uint32_t target = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    target = far_from(target, reel.frames, random);
    const double begin = now_ms();
    playback.seek(playback.timeline().times_us[target], Clock::TimePoint::clock::now());
    double coarse = 0.0;
    std::shared_ptr<const SceneFrame> checked;
    const bool there = watching.until([&](const ReelPlayback::Update& update) {
      if (!update.frame || update.frame->index != target) return false;
      if (coarse == 0.0) coarse = now_ms() - begin;
      return update.frame->level == kWholeFrame && (checked = update.frame);
    });
    if (!there) {
      ++seeks.missing;
      continue;
    }
    seeks.exact.add(now_ms() - begin);
    seeks.coarse.add(coarse);
    seeks.decode.add(checked->decode_ms + checked->normals_ms + checked->svo_ms);
    seeks.wrong += !is_right(reel, *checked);
  }
}

void drag(Watching& watching, const StreamedReel& reel, int count, Seeks& seeks,
          std::mt19937_64& random) {
  ReelPlayback& playback = watching.playback();
  std::uint32_t target = 0;
  playback.scrub_begin(Clock::TimePoint::clock::now());
  for (int i = 0; i < count; ++i) {
    target = far_from(target, reel.frames, random);
    const double begin = now_ms();
    playback.scrub_to(playback.timeline().times_us[target], Clock::TimePoint::clock::now());
    std::shared_ptr<const SceneFrame> shown;
    const bool there = watching.until([&](const ReelPlayback::Update& update) {
      return update.frame && update.frame->index == target && (shown = update.frame);
    });
    if (there) {
      seeks.dragged.add(now_ms() - begin);
      seeks.wrong += !is_right(reel, *shown);
    } else {
      ++seeks.missing;
    }
  }
  playback.scrub_end(Clock::TimePoint::clock::now());
}

}  // namespace

Result<json> run_seek(const StreamOptions& options, std::vector<Bar>& bars) {
  const auto served = TRY(ServedReels::start(options));
  json rows = json::array();
  std::uint64_t wrong = 0, checked = 0;
  std::mt19937_64 random(6);
  for (const StreamedReel& reel : served->reels()) {
    for (const NamedLink& named : {loopback(), megabits(50)}) {
      const bool near = named.conditions.bits_per_second == 0;
      const auto link = TRY(served->link(named));
      const auto watching = TRY(Watching::start(
          near ? served->url(reel) : ServedReels::url(*link, reel), {.keep_nothing = true}));
      if (!watching->until([](const auto& update) { return update.frame != nullptr; })) {
        return fail(ErrorCode::io, reel.name + ": no picture came");
      }
      watching->playback().pause(Clock::TimePoint::clock::now());
      const bool many = near && reel.name == "soccer-shoot";
      const std::uint64_t count = options.quick ? 40 : many ? 10'000 : 500;
      Seeks seeks;
      seek(*watching, reel, count, seeks, random);
      drag(*watching, reel, options.quick ? 40 : 300, seeks, random);
      wrong += seeks.wrong + seeks.missing;
      checked += count;
      bars.push_back({fmt::format("seek, {}, {}: exact picture, 95 %", reel.name, named.name),
                      seeks.exact.summary().p95, "ms", near ? 100.0 : 250.0});
      if (!near)
        bars.push_back({fmt::format("drag, {}, {}: coarse picture, 95 %", reel.name, named.name),
                        seeks.dragged.summary().p95, "ms", 40.0});
      rows.push_back({{"reel", reel.name},
                      {"link", named.name},
                      {"seeks", count},
                      {"exact_ms", json_of(seeks.exact)},
                      {"of_which_decoding_ms", json_of(seeks.decode)},
                      {"coarse_ms", json_of(seeks.coarse)},
                      {"drag_coarse_ms", json_of(seeks.dragged)},
                      {"wrong", seeks.wrong},
                      {"missing", seeks.missing}});
    }
  }
  bars.push_back(
      {fmt::format("{} random seeks: wrong frames", checked), static_cast<double>(wrong), "", 0.0});
  return json{{"rows", rows}};
}

}  // namespace pointreel::bench
