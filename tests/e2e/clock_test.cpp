// Live streams while the clock of one of the programs is set: by libfaketime, which makes a program
// see another time of day, but the same steady clock.

#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/files/ply.h"
#include "codec/live/live.h"
#include "codec/package/manifest.h"
#include "common/net/websocket.h"
#include "pointreel/package.h"
#include "tests/e2e/process.h"
#include "tests/e2e/server_address.h"
#include "tests/temporary_folder.h"
#include "tests/wait.h"

namespace pointreel::e2e::clock_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Steady = std::chrono::steady_clock;

/// How far clocks are set, and less than which a clock that was not set may be wrong.
constexpr double kJumpSeconds = 7200.0, kNoJumpSeconds = 600.0;

/// A clock that a program sees instead of the machine's.
class SetClock {
 public:
  explicit SetClock(fs::path file) : file_(std::move(file)) { set(0); }

  /// The library replaces the file's old content in one step.
  void set(double seconds) const {
    const fs::path beside = file_.string() + ".new";
    std::ofstream(beside) << fmt::format("{:+}\n", seconds);
    fs::rename(beside, file_);
  }

  Surroundings surroundings() const {
    Surroundings seen;
    seen.environment = {fmt::format("LD_PRELOAD={}", POINTREEL_FAKETIME),
                        fmt::format("FAKETIME_TIMESTAMP_FILE={}", file_.string()),
                        "FAKETIME_NO_CACHE=1", "DONT_FAKE_MONOTONIC=1",
                        "FAKETIME_DONT_FAKE_MONOTONIC=1"};
    return seen;
  }

 private:
  fs::path file_;
};

PointCloud stick(int points) {
  PointCloud cloud;
  for (int i = 0; i < points; ++i) {
    cloud.positions.emplace_back(0.01f * static_cast<float>(i % 10), 0.001f * static_cast<float>(i),
                                 0.0f);
  }
  return cloud;
}

/// Whose clock is set, and how far.
struct Jump {
  std::string whose;
  double seconds;
};

void PrintTo(const Jump& jump, std::ostream* out) {
  *out << jump.whose << fmt::format(" {:+}", jump.seconds);
}

class ClockTest : public testing::TestWithParam<Jump> {
 protected:
  void SetUp() override {
    if (!fs::exists(POINTREEL_FAKETIME)) {
      GTEST_SKIP() << "libfaketime is not installed: apt-get install faketime";
    }
#ifdef POINTREEL_SANITIZED
    GTEST_SKIP() << "a sanitizer must be the first library of a program";
#endif
    fs::create_directories(frames());
    server_ = start("server", {"serve", "--live", "--record", (folder_ / "record").string(),
                               "--listen", "127.0.0.1:0"});
    address_ = server_address(*server_);
    ASSERT_FALSE(address_.empty());
  }

  fs::path frames() const { return folder_ / "frames"; }
  std::string url() const { return "ws://" + address_ + "/live/stage"; }

  /// Starts a subcommand of the server; `whose` decides whether it sees the clock that is set.
  std::unique_ptr<Background> start(const std::string& whose, std::vector<std::string> arguments,
                                    const std::string& program = "pointreel-server") {
    const bool set = whose == GetParam().whose;
    return std::make_unique<Background>(program, arguments,
                                        set ? clock_.surroundings() : Surroundings{});
  }

  /// Adds a file to the folder in one step.
  void add_frame(int number) const {
    const fs::path unfinished = frames() / "unfinished";
    ASSERT_TRUE(write_ply(unfinished, stick(50 + number)));
    fs::rename(unfinished, frames() / fmt::format("{}.ply", number));
  }

  /// Waits for the frame of this number as a viewer. Nothing if it does not come.
  std::optional<LiveLayer> see(int number) {
    std::optional<LiveLayer> seen;
    wait_until([&] {
      if (!viewer_) {
        auto socket = WebSocket::connect(url());
        if (socket) viewer_ = *std::move(socket);
        return false;
      }
      const auto message = viewer_->receive(1s);
      if (!message) viewer_.reset();
      if (!message || !*message) return false;
      if (const auto layer = parse_live_layer((*message)->bytes)) {
        if (layer->points == static_cast<std::uint32_t>(50 + number)) seen = *layer;
      }
      return seen.has_value();
    });
    return seen;
  }

  const TemporaryFolder folder_;
  const SetClock clock_{folder_ / "clock"};
  std::unique_ptr<Background> server_;
  std::string address_;
  std::unique_ptr<WebSocket> viewer_;
};

TEST_P(ClockTest, a_clock_that_is_set_neither_stops_a_stream_nor_changes_times) {
  constexpr int kFrames = 12;
  const auto publisher =
      start("publisher", {"publish", "-i", frames().string(), "--follow", "--to", url()});
  const auto begin = Steady::now();
  std::vector<std::uint64_t> captured;
  for (int i = 0; i < kFrames; ++i) {
    if (i == kFrames / 2) clock_.set(GetParam().seconds);
    add_frame(i);
    const auto seen = see(i);
    ASSERT_TRUE(seen) << "frame " << i;
    captured.push_back(seen->capture_us);
  }
  const auto passed = std::chrono::duration_cast<std::chrono::microseconds>(Steady::now() - begin);
  EXPECT_LE(captured.back() - captured.front(), static_cast<std::uint64_t>(passed.count()));
  EXPECT_EQ(publisher->end(SIGINT), 0);
  EXPECT_EQ(server_->end(SIGTERM), 0);
  const auto manifest = read_manifest(folder_ / "record" / "stage");
  ASSERT_TRUE(manifest) << manifest.error().message;
  ASSERT_EQ(manifest->frame_count(), static_cast<std::uint32_t>(kFrames));
  for (std::uint32_t i = 0; i < kFrames; ++i) {
    EXPECT_EQ(frame_time_us(*manifest, i), captured[i] - captured[0]);
  }
}

TEST_P(ClockTest, a_folder_is_played_at_its_pace_while_a_clock_is_set) {
  constexpr int kFrames = 24;
  for (int i = 0; i < kFrames; ++i) add_frame(i);
  const auto publisher = start(
      "publisher", {"publish", "-i", frames().string(), "--fps", "20", "--json", "--to", url()});
  ASSERT_TRUE(see(3));
  clock_.set(GetParam().seconds);
  EXPECT_EQ(publisher->end(0), 0) << "it does not wait for the old time to come again";
  EXPECT_EQ(server_->end(SIGTERM), 0);
  const auto manifest = read_manifest(folder_ / "record" / "stage");
  ASSERT_TRUE(manifest) << manifest.error().message;
  // On a busy machine, frames are skipped, also at the ends.
  EXPECT_LE(manifest->duration_us, kFrames * 50'000u);
  EXPECT_GE(manifest->duration_us, kFrames * 50'000u / 2);
  EXPECT_GE(manifest->frame_count(), kFrames / 2u) << "it does not skip what is not yet due";
}

TEST_P(ClockTest, delays_are_those_between_capture_and_picture) {
  for (int i = 0; i < 3; ++i) add_frame(i);
  const auto publisher = start(
      "publisher", {"publish", "-i", frames().string(), "--loop", "--fps", "10", "--to", url()});
  ASSERT_TRUE(see(0));
  for (const std::string& source : {url(), "http://" + address_ + "/live/stage/reel.json"}) {
    clock_.set(0);
    const fs::path pictures = folder_ / (source.starts_with("ws") ? "ws" : "http");
    fs::create_directories(pictures);
    const std::string report = (pictures / "report.json").string();
    const auto player = start("viewer",
                              {"play", source, "--offscreen", "16x16", "--record",
                               (pictures / "%d.png").string(), "--json", report},
                              "pointreel");
    const auto shown = [&](int number) {
      return wait_until([&] { return fs::exists(pictures / fmt::format("{}.png", number)); });
    };
    ASSERT_TRUE(shown(2)) << source;
    clock_.set(GetParam().seconds);
    ASSERT_TRUE(shown(8)) << source << " stopped when the clock was set";
    EXPECT_EQ(player->end(SIGINT), 0);
    std::ifstream in(report);
    const auto json = nlohmann::json::parse(in, nullptr, false);
    ASSERT_FALSE(json.is_discarded()) << source;
    const auto& delay = json["sources"][0]["live"]["capture_to_picture_ms"];
    EXPECT_GE(delay["median"].get<double>(), 0.0) << delay;
    EXPECT_LT(delay["max"].get<double>(), 1e3 * kNoJumpSeconds) << delay;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Jumps, ClockTest,
    testing::Values(Jump{"publisher", -kJumpSeconds}, Jump{"publisher", kJumpSeconds},
                    Jump{"server", -kJumpSeconds}, Jump{"server", kJumpSeconds},
                    Jump{"viewer", -kJumpSeconds}, Jump{"viewer", kJumpSeconds}),
    [](const auto& of) { return of.param.whose + (of.param.seconds < 0 ? "_back" : "_ahead"); });

}  // namespace
}  // namespace pointreel::e2e::clock_test
