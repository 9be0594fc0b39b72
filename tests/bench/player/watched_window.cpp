#include "tests/bench/player/watched_window.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include <fmt/format.h>

#include "common/base/try.h"
#include "tests/e2e/process.h"

namespace pointreel::bench {

namespace {

/// Heights of the timeline and of the messages at the top, with a margin.
constexpr int kBarHeight = 100, kTopHeight = 60;

bool differ(const glm::u8vec3& one, const glm::u8vec3& other) {
  constexpr int kRounding = 2;
  for (int i = 0; i < 3; ++i)
    if (std::abs(int{one[i]} - int{other[i]}) > kRounding) return true;
  return false;
}

/// The rows in which the interface does not write by itself.
e2e::Picture without_texts(const e2e::Picture& picture) {
  const int bottom = std::max(kTopHeight, picture.size.y - kBarHeight);
  return picture.size.y < bottom ? e2e::Picture{} : e2e::rows(picture, kTopHeight, bottom);
}

/// The share of the pixels that differ; 1 if the pictures have different sizes.
double share_that_differs(const e2e::Picture& one, const e2e::Picture& other) {
  if (one.size != other.size || one.pixels.empty()) return 1.0;
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < one.pixels.size(); ++i)
    wrong += differ(one.pixels[i], other.pixels[i]);
  return static_cast<double>(wrong) / static_cast<double>(one.pixels.size());
}

}  // namespace

Result<WatchedWindow> WatchedWindow::open(const StreamOptions& options,
                                          const std::vector<std::string>& arguments) {
  WatchedWindow watched;
  watched.display = TRY(window::VirtualDisplay::start());
  std::vector<std::string> all = {"--no-config"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  watched.player =
      TRY(window::PlayerWindow::open(*watched.display, {all, options.scratch / "player", {}}));
  return watched;
}

bool WatchedWindow::wait_for_picture() const {
  return window::wait_until([&] {
    const e2e::Picture picture = player->picture();
    if (picture.pixels.empty()) return false;
    const glm::ivec2 middle = picture.size / 2;
    // Below the middle, because the window shows messages in it while loading.
    for (int y = middle.y + 40; y < middle.y + 120; y += 4)
      for (int x = middle.x - 40; x < middle.x + 40; x += 4)
        if (differ(picture.at(x, y), picture.at(0, 0))) return true;
    return false;
  });
}

void WatchedWindow::wait_until_settled() const {
  window::wait_until_still([&] { return without_texts(player->picture()); },
                           std::chrono::milliseconds(1500));
}

Result<nlohmann::json> WatchedWindow::quit() {
  nlohmann::json report = player->quit();
  if (player->exit_code() != 0 || report.is_discarded())
    return fail(ErrorCode::io, "pointreel play failed: " + player->err());
  return report;
}

Result<double> WatchedWindow::differing_share(const std::string& reel, double at,
                                              const StreamOptions& options) const {
  const glm::ivec2 size = player->size();
  const std::string png = (options.scratch / "truth.png").string();
  const e2e::Outcome drawn =
      e2e::run("pointreel", {"play", reel, "--at", fmt::format("{:.6f}", at), "--offscreen",
                             fmt::format("{}x{}", size.x, size.y), "--screenshot", png});
  if (drawn.exit_code != 0) return fail(ErrorCode::io, "pointreel play: " + drawn.err);
  const e2e::Picture truth = without_texts(e2e::read_picture(png));
  double share = 1.0;
  window::wait_until(
      [&] {
        share = share_that_differs(without_texts(player->picture()), truth);
        return share == 0.0;
      },
      std::chrono::seconds(10));
  return share;
}

}  // namespace pointreel::bench
