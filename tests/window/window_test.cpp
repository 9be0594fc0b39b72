#include "tests/window/window_test.h"

#include <cstdlib>

#include "client/render/image.h"
#include "tests/paths.h"

namespace pointreel::window {

using std::chrono::milliseconds;

Stand& Stand::get() {
  static Stand stand;
  return stand;
}

void WindowTest::SetUp() {
  if (const std::string missing = VirtualDisplay::missing(); !missing.empty())
    GTEST_SKIP() << missing << " is not installed: apt-get install " << missing;
  Stand& stand = Stand::get();
  if (stand.display == nullptr) {
    auto display = VirtualDisplay::start();
    ASSERT_TRUE(display) << display.error().message;
    auto made = MovingPlate::make(stand.folder.path());
    ASSERT_TRUE(made) << made.error().message;
    stand.plate = *std::move(made);
    stand.display = *std::move(display);
  }
}

void WindowTest::open(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), plate().reel());
  open_sources(std::move(arguments));
}

void WindowTest::open_sources(std::vector<std::string> arguments) {
  player_.reset();
  // Moves the mouse away from where windows appear.
  display().xdotool({"mousemove", "1599", "999"});
  const auto crash_report = program_folder() / "libpointreel_crash_report.so";
  auto opened = PlayerWindow::open(
      display(), {std::move(arguments), folder_.path(), {"LD_PRELOAD=" + crash_report.string()}});
  ASSERT_TRUE(opened) << opened.error().message;
  player_ = *std::move(opened);
}

int WindowTest::frame() const { return plate().frame(player_->picture()).value_or(-1); }

bool WindowTest::wait_for_frame(int number) const {
  return wait_until([&] { return frame() == number; });
}

int WindowTest::paused_frame() const {
  return wait_until_still([&] { return frame(); },
                          milliseconds(1200),  // six frames: machines are busy
                          [](int number) { return number >= 0; })
      .value_or(-1);
}

bool WindowTest::wait_for_next_frame() const {
  int before = -1;
  return wait_until([&] {
    const int now = frame();
    if (before < 0) before = now;
    return now >= 0 && now != before;
  });
}

void WindowTest::pause() {
  ASSERT_TRUE(wait_until([&] { return frame() >= 0; })) << player_->err();
  player_->key("space");
  ASSERT_GE(paused_frame(), 0) << "playback must pause";
}

void WindowTest::keep(const std::string& name) const {
  const char* folder = std::getenv("POINTREEL_WINDOW_PICTURES");
  if (folder == nullptr) return;
  const e2e::Picture picture = player_->picture();
  EXPECT_TRUE(write_png(std::string(folder) + "/" + name + ".png",
                        {picture.size.x, picture.size.y, picture.pixels}));
}

nlohmann::json WindowTest::quit() {
  const nlohmann::json report = player_->quit();
  EXPECT_EQ(player_->exit_code(), 0) << player_->err();
  EXPECT_FALSE(report.is_discarded()) << player_->err();
  return report;
}

}  // namespace pointreel::window
