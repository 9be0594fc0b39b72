// Opening sources from the command line and by dropping them, and sources that cannot be opened.

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/link/link_emulator.h"
#include "tests/window/window_test.h"

namespace pointreel::window::opening_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class OpeningWindow : public WindowTest {
 protected:
  bool wait_for_plate() {
    return wait_until([&] { return MovingPlate::plate(player().picture()).pixels > 500; });
  }
  bool wait_for_title(const std::string& part) {
    return wait_until([&] { return player().title().find(part) != std::string::npos; });
  }
  bool wait_for_err(const std::string& part) {
    return wait_until([&] { return player().err().find(part) != std::string::npos; });
  }
  /// The number of pixels in the window that are as bright as text.
  std::ptrdiff_t bright() {
    const e2e::Picture picture = player().picture();
    return std::count_if(picture.pixels.begin(), picture.pixels.end(),
                         [](const glm::u8vec3& c) { return std::min({c.r, c.g, c.b}) > 140; });
  }

  /// The width from the first to the last column with such pixels.
  int bright_width() {
    const e2e::Picture picture = player().picture();
    int first = picture.size.x, last = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
      const glm::u8vec3& c = picture.pixels[i];
      if (std::min({c.r, c.g, c.b}) <= 140) continue;
      const int x = static_cast<int>(i % static_cast<std::size_t>(picture.size.x));
      first = std::min(first, x);
      last = std::max(last, x);
    }
    return last - first;
  }

  /// Expects the message in the window and as one line on standard error. Then "q" ends the player
  /// with an error.
  void expect_error(const std::string& part) {
    EXPECT_TRUE(wait_for_err(part)) << player().err();
    EXPECT_TRUE(wait_until([&] { return bright() > 200; })) << "the window must show a line";
    const auto report = player().quit();
    EXPECT_EQ(player().exit_code(), 1);
    const std::string err = player().err();
    EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
    ASSERT_FALSE(report.is_discarded());
    EXPECT_THAT(report["window"]["error"], HasSubstr(part));
  }
};

TEST_F(OpeningWindow, a_dropped_folder_package_or_ply_is_played) {
  open();
  ASSERT_TRUE(wait_for_next_frame());
  ASSERT_TRUE(player().drop({plate().ply(7)}));
  EXPECT_TRUE(wait_for_title("7.ply")) << player().title();
  EXPECT_TRUE(wait_for_plate());
  keep("dropped a ply");
  ASSERT_TRUE(player().drop({plate().ply(0).parent_path()}));
  EXPECT_TRUE(wait_for_title(": in")) << player().title();
  EXPECT_TRUE(wait_for_next_frame());
  ASSERT_TRUE(player().drop({plate().reel()}));
  EXPECT_TRUE(wait_for_title(": plate")) << player().title();
  EXPECT_TRUE(wait_for_next_frame());
  const auto report = quit();
  EXPECT_EQ(report["sources"][0]["source"], plate().reel());
  EXPECT_EQ(player().err(), "");
}

TEST_F(OpeningWindow, several_dropped_files_are_played_as_a_reel) {
  open();
  ASSERT_TRUE(wait_for_next_frame());
  ASSERT_TRUE(player().drop({plate().ply(10), plate().ply(9), plate().ply(11)}));
  EXPECT_TRUE(wait_for_title("9.ply")) << player().title();
  EXPECT_TRUE(wait_for_plate());
  quit();
}

TEST_F(OpeningWindow, an_unplayable_drop_is_reported_and_the_current_reel_plays_on) {
  open();
  ASSERT_TRUE(wait_for_next_frame());
  ASSERT_TRUE(player().drop({folder_.write("notes.ply", "not a cloud at all")}));
  EXPECT_TRUE(wait_for_err("notes.ply")) << player().err();
  keep("dropped what is no cloud");
  EXPECT_TRUE(wait_for_title(": plate")) << "the title must return, not " << player().title();
  ASSERT_TRUE(player().drop({plate().reel()}));
  EXPECT_TRUE(wait_for_title(": plate"));
  EXPECT_TRUE(wait_for_next_frame());
  EXPECT_FALSE(quit()["window"].contains("error"));
}

TEST_F(OpeningWindow, a_missing_folder_is_an_error_in_the_window) {
  open_sources({(folder_ / "nowhere").string()});
  EXPECT_TRUE(wait_for_err("nowhere"));
  keep("not there");
  expect_error("nowhere");
}

TEST_F(OpeningWindow, an_unreachable_host_is_an_error_in_the_window) {
  open_sources({"http://127.0.0.1:9/reel"});
  expect_error("127.0.0.1:9");
}

TEST_F(OpeningWindow, a_newer_format_is_reported_with_its_version) {
  fs::copy(plate().reel(), folder_ / "newer", fs::copy_options::recursive);
  std::ifstream in(folder_ / "newer/reel.json");
  std::string manifest(std::istreambuf_iterator<char>(in), {});
  auto json = nlohmann::json::parse(manifest);
  json["version"] = 99;
  folder_.write("newer/reel.json", json.dump());
  open_sources({(folder_ / "newer").string()});
  expect_error("99");
}

TEST_F(OpeningWindow, a_window_stays_usable_while_a_host_does_not_answer) {
  const auto link = LinkEmulator::start({.target = "127.0.0.1:9", .conditions = {.cut = true}});
  ASSERT_TRUE(link) << link.error().message;
  open_sources({"http://" + (*link)->address() + "/slow-reel"});
  EXPECT_TRUE(wait_for_title("slow-reel")) << player().title();
  EXPECT_TRUE(wait_until([&] { return bright() > 200; })) << "the source must be named";
  keep("loading");
  // Meanwhile another reel can be played at once.
  ASSERT_TRUE(player().drop({plate().reel()}));
  EXPECT_TRUE(wait_for_next_frame());
  quit();
  open_sources({"http://" + (*link)->address() + "/slow-reel"});
  EXPECT_TRUE(wait_for_title("slow-reel"));
  quit();
}

TEST_F(OpeningWindow, a_silent_host_is_reported_and_escape_stops_waiting) {
  const auto link = LinkEmulator::start({.target = "127.0.0.1:9", .conditions = {.cut = true}});
  ASSERT_TRUE(link) << link.error().message;
  open_sources({"http://" + (*link)->address() + "/slow-reel"});
  EXPECT_TRUE(wait_until([&] { return bright_width() > 50; })) << "the source must be named";
  const int loading = bright_width();
  EXPECT_TRUE(wait_until([&] { return bright_width() > 2 * loading; })) << "no reason for waiting";
  keep("silent host");
  player().key("Escape");
  expect_error("slow-reel: loading was given up");
}

}  // namespace
}  // namespace pointreel::window::opening_test
