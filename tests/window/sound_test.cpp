// Sound, on a device that nobody hears.

#include <cmath>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/package/manifest.h"
#include "common/process/ffmpeg.h"
#include "server/pack/audio.h"
#include "tests/e2e/server_address.h"
#include "tests/read_file.h"
#include "tests/tone.h"
#include "tests/window/window_test.h"

namespace pointreel::window::sound_test {
namespace {

namespace fs = std::filesystem;

class SoundWindow : public WindowTest {
 protected:
  void SetUp() override {
    if (!is_installed("ffmpeg")) GTEST_SKIP() << "ffmpeg is not installed";
    WindowTest::SetUp();
    if (IsSkipped()) return;
    fs::copy(plate().reel(), reel());
    write_wav(folder_ / "a.wav", 48'000, 480'000,
              [](std::uint32_t n) { return 0.5 * std::sin(0.05 * n); });
    const auto added = replace_audio(reel(), folder_ / "a.wav");
    ASSERT_TRUE(added) << added.error().message;
  }
  fs::path reel() const { return folder_ / "reel"; }
  fs::path audio() const { return reel() / read_manifest(reel())->audio->path; }
};

TEST_F(SoundWindow, a_reel_is_heard_with_its_pictures) {
  open_sources({reel(), "--audio-device", "null"});
  EXPECT_TRUE(wait_for_next_frame());
  player().key("Right");
  EXPECT_TRUE(wait_for_next_frame());
  const auto audio = quit()["window"]["audio"];
  EXPECT_TRUE(audio["plays"].get<bool>());
  EXPECT_NEAR(audio["ahead_of_picture_ms"]["worst"].get<double>(), 0.0, 20.0);
  EXPECT_EQ(player().err(), "");
}

/// Of a stream, over WebSocket ("ws") or over HTTP ("http").
class LiveSoundWindow : public SoundWindow, public testing::WithParamInterface<const char*> {};

INSTANTIATE_TEST_SUITE_P(Over, LiveSoundWindow, testing::Values("ws", "http"),
                         [](const auto& scheme) { return std::string(scheme.param); });

TEST_P(LiveSoundWindow, is_heard_with_the_delay_of_its_pictures) {
  e2e::Background server("pointreel-server", {"serve", "--live", "--listen", "127.0.0.1:0"});
  const std::string place = "://" + e2e::server_address(server) + "/live/plate";
  const e2e::Background publisher("pointreel-server",
                                  {"publish", "-i", plate().ply(0).parent_path().string(), "--loop",
                                   "--audio", (folder_ / "a.wav").string(), "--to", "ws" + place});
  open_sources({GetParam() + place, "--audio-device", "null"});
  // Over HTTP, the sound of the first segment may have come before the player listens.
  for (int i = 0; i < 30; ++i) EXPECT_TRUE(wait_for_next_frame());
  const auto audio = quit()["window"]["audio"];
  EXPECT_TRUE(audio["plays"].get<bool>());
  EXPECT_GT(audio["first_sound_ms"].get<double>(), 0.0);
  EXPECT_NEAR(audio["ahead_of_picture_ms"]["mean"].get<double>(), 0.0, 20.0);
  EXPECT_GT(audio["capture_to_sound_ms"].get<double>(), 0.0);
}

TEST_F(SoundWindow, keys_change_the_volume_which_is_kept) {
  open_sources({reel(), "--audio-device", "null", "--volume", "80"});
  EXPECT_TRUE(wait_for_next_frame());
  player().key("slash");
  player().key("slash");
  player().key("asterisk");
  player().key("M");
  quit();
  const auto kept = nlohmann::json::parse(read_file(folder_ / "config/pointreel/player.json"));
  EXPECT_EQ(kept["volume"], 75.0);
  EXPECT_EQ(kept["mute"], true);
}

TEST_F(SoundWindow, plays_on_where_there_is_no_device) {
  open_sources({reel(), "--audio-device", "no_such_device"});
  EXPECT_TRUE(wait_for_next_frame());
  EXPECT_TRUE(wait_for_next_frame());
  const auto audio = quit()["window"]["audio"];
  EXPECT_FALSE(audio["plays"].get<bool>());
  EXPECT_EQ(player().err(), "");
}

TEST_F(SoundWindow, without_audio_nothing_of_it_is_fetched) {
  fs::remove(audio());
  open_sources({reel(), "--no-audio"});
  EXPECT_TRUE(wait_for_next_frame());
  EXPECT_FALSE(quit()["window"].contains("audio"));
  EXPECT_EQ(player().err(), "");
}

TEST_F(SoundWindow, says_that_sound_is_missing_and_plays_on) {
  fs::remove(audio());
  open_sources({reel(), "--audio-device", "null"});
  EXPECT_TRUE(wait_for_next_frame());
  EXPECT_TRUE(wait_until([&] { return player().err().find("sound: ") != std::string::npos; }));
  EXPECT_TRUE(wait_for_next_frame());
  quit();
}

}  // namespace
}  // namespace pointreel::window::sound_test
