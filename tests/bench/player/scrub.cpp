#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <random>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "common/base/try.h"
#include "tests/bench/player/player_chapters.h"
#include "tests/bench/player/watched_window.h"
#include "tests/bench/stream/reels.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

constexpr double kFrameMs = 1000.0 / 30.0;  ///< frame interval of streamed_reels

/// The pixel at a share of the timeline, which has a margin of 14 pixels on each side.
glm::ivec2 on_timeline(glm::ivec2 size, double share) {
  return {static_cast<int>(std::lround(14.0 + share * (size.x - 28.0))), size.y - 45};
}

/// The frame for which a column of the timeline stands.
std::uint32_t frame_at(int x, glm::ivec2 size, std::uint32_t frames) {
  return static_cast<std::uint32_t>((x - 14.0) / (size.x - 28.0) * frames);
}

enum class Hand {
  anywhere,  ///< each move goes to a random place, where hardly anything is loaded yet
  searching  ///< moves mostly go on a little or much, and now and then far away
};

const char* name(Hand hand) { return hand == Hand::anywhere ? "anywhere" : "searching"; }

/// The places on the timeline to which the hand moves, as shares of it.
std::vector<double> path_of(Hand hand, int moves) {
  std::mt19937_64 random(7);
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() % 10'000) / 10'000.0;
  };
  std::vector<double> path;
  double share = 0.5, direction = 1.0;
  for (int move = 0; move < moves; ++move) {
    const double which = between(0.0, 1.0);
    if (hand == Hand::anywhere || which < 0.05) {
      share = between(0.0, 1.0);
    } else {
      if (which < 0.2) direction = -direction;
      share += direction * (which < 0.9 ? between(0.001, 0.01) : between(0.01, 0.1));
    }
    share = std::clamp(share, 0.0, 0.9999);
    path.push_back(share);
  }
  return path;
}

/// The player's report of a drag, and what the window shows at its end.
struct Drag {
  json report;
  double off_by = 0.0;   ///< distance in frames from the frame under the cursor
  double differs = 0.0;  ///< share of the pixels that differ from those drawn without a window
};

Result<Drag> drag(const StreamedReel& reel, const std::string& where,
                  const std::vector<double>& path, const StreamOptions& options) {
  WatchedWindow watched = TRY(WatchedWindow::open(options, {where}));
  if (!watched.wait_for_picture())
    return fail(ErrorCode::io, reel.name + ": the window shows no picture");
  window::PlayerWindow& player = *watched.player;
  const glm::ivec2 size = player.size();
  player.key("space");
  player.press(on_timeline(size, 0.5));
  for (const double share : path) {
    player.move_to(on_timeline(size, share));
    std::this_thread::sleep_for(std::chrono::milliseconds(options.quick ? 60 : 120));
  }
  // The frame that was asked for last must appear before the button is released.
  watched.wait_until_settled();
  player.release();
  player.move_to(size / 3);  // so that no thumbnail covers the picture
  const std::uint32_t frame = frame_at(on_timeline(size, path.back()).x, size, reel.frames);
  // The middle of the frame, so that rounding cannot lead to its neighbour.
  const double seconds = (frame + 0.5) * kFrameMs / 1000.0;
  const double differs = TRY(watched.differing_share(reel.folder.string(), seconds, options));
  json report = TRY(watched.quit());
  const double shown = report["window"]["frame"];
  return Drag{std::move(report), std::abs(shown - frame), differs};
}

}  // namespace

Result<json> run_player_scrub(const StreamOptions& options, std::vector<Bar>& bars) {
  const auto served = TRY(ServedReels::start(options));
  const int moves = options.quick ? 40 : 300;
  json rows = json::array();
  for (const StreamedReel& reel : served->reels()) {
    for (const bool local : {true, false}) {
      const NamedLink named = local ? NamedLink{"folder", {}} : megabits(50);
      const auto link = TRY(served->link(named));
      const std::string where = local ? reel.folder.string() : ServedReels::url(*link, reel);
      // The time to fetch a base layer, from the first hand, for which all are fetched.
      std::optional<double> base_ms;
      for (const Hand hand : {Hand::anywhere, Hand::searching}) {
        const Drag dragged = TRY(drag(reel, where, path_of(hand, moves), options));
        const json& report = dragged.report;
        const json& times = report["window"]["scrub_to_picture_ms"];
        if (!base_ms) base_ms = report["fetch_ms"]["median"];
        const std::string what =
            fmt::format("scrub, {}, {}, {}", reel.name, named.name, name(hand));
        bars.push_back({what + ": move to picture, 95 %", times["p95"], "ms", kFrameMs + *base_ms});
        bars.push_back({what + ": last frame is off by", dragged.off_by, "", 0.0});
        bars.push_back({what + ": pixels that differ from those without a window",
                        100.0 * dragged.differs, "%", 0.0});
        rows.push_back({{"reel", reel.name},
                        {"from", named.name},
                        {"hand", name(hand)},
                        {"moves", moves},
                        {"scrub_to_picture_ms", times},
                        {"frame_ms", kFrameMs},
                        {"fetch_ms", report["fetch_ms"]},
                        {"decode_ms", report["decode_ms"]},
                        {"render_ms", report["render_ms"]},
                        {"pixels_unlike_offscreen", dragged.differs}});
      }
    }
  }
  return json{{"rows", rows}};
}

}  // namespace pointreel::bench
