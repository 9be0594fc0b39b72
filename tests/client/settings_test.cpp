#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/options/settings_file.h"
#include "tests/temporary_folder.h"

namespace pointreel::settings_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Sets an environment variable and restores it at the end.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    value != nullptr ? ::setenv(name, value, 1) : ::unsetenv(name);
  }
  ~Variable() { before_.empty() ? ::unsetenv(name_) : ::setenv(name_, before_.c_str(), 1); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::string before_;
};

Settings changed_in_everything() {
  Settings options;
  options.size = {800, 601};
  options.loop = false;
  options.draw.mode = DrawMode::point;
  options.draw.instancing = Instancing::texture;
  options.draw.splatting = Splatting::two_pass;
  options.draw.color = ColorSource::normals;
  options.floor = true;
  options.draw.scales = {1.1f, 0.7f};
  options.draw.fill_holes = options.draw.lighting = false;
  options.delta = 0.05;
  options.draw.edl = 0.3f;
  options.draw.pixel_size = 2.5f;
  options.draw.background = {1.0f, 0.0f, 128.0f / 255.0f};
  options.draw.color = ColorSource::plain;
  options.draw.point_size = 3.5f;
  options.floor = true;
  options.drafts = Drafts::moving;
  options.drawing_panel = options.statistics_panel = true;
  return options;
}

TEST(Settings, changes_are_restored_the_next_time) {
  const TemporaryFolder folder;
  const fs::path file = folder / "in/a/folder/player.json";
  ASSERT_TRUE(write_settings(file, Settings(), changed_in_everything()));
  Settings next;
  const auto read = read_settings(file, next);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(next, changed_in_everything());
}

TEST(Settings, only_changes_are_written_and_unknown_keys_are_kept) {
  const TemporaryFolder folder;
  const fs::path file =
      folder.write("player.json", R"({"edl": 0.5, "of_a_newer_version": [1, 2]})");
  Settings begun;
  begun.draw.mode = DrawMode::voxel;  // set on the command line
  Settings ended = begun;
  ended.draw.pixel_size = 0.1f;
  ASSERT_TRUE(write_settings(file, begun, ended));
  EXPECT_EQ(json::parse(content(file)),
            json({{"edl", 0.5}, {"of_a_newer_version", {1, 2}}, {"pixel_size", 0.1}}));
}

TEST(Settings, no_file_is_written_without_changes) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_settings(folder / "player.json", Settings(), Settings()));
  EXPECT_FALSE(fs::exists(folder / "player.json"));
  Settings ended;
  ended.loop = true;  // the default in a window
  ASSERT_TRUE(write_settings(folder / "player.json", Settings(), ended));
  EXPECT_FALSE(fs::exists(folder / "player.json"));
}

TEST(Settings, an_earlier_name_of_an_option_is_read_but_replaced_when_it_is_written) {
  const TemporaryFolder folder;
  const fs::path file = folder.write("player.json", R"({"delta": 0.25, "edl": 0.5})");
  Settings begun;
  ASSERT_TRUE(read_settings(file, begun));
  EXPECT_EQ(begun.delta, 0.25);
  Settings ended = begun;
  ended.delta = 0.5;
  ASSERT_TRUE(write_settings(file, begun, ended));
  EXPECT_EQ(json::parse(content(file)), json({{"voxel_merge", 0.5}, {"edl", 0.5}}));
  EXPECT_FALSE(parse_settings(R"({"delta": 2})", begun));
}

TEST(Settings, a_missing_or_empty_file_changes_nothing) {
  const TemporaryFolder folder;
  Settings options;
  EXPECT_TRUE(read_settings(folder / "none/player.json", options));
  EXPECT_TRUE(read_settings(folder.write("player.json", " \n"), options));
  EXPECT_EQ(options, Settings());
}

TEST(Settings, a_broken_file_is_reported_in_one_line_and_left_unchanged) {
  const TemporaryFolder folder;
  for (const std::string text :
       {"mode = voxel", "[1]", "{\"edl\": 0.5", "{\"mode\": \"disc\"}", "{\"mode\": 3}",
        "{\"edl\": \"much\"}", "{\"edl\": -1}", "{\"edl\": 1e999}", "{\"pixel_size\": null}",
        "{\"window\": [1280]}", "{\"window\": [1280, 1e9]}", "{\"window\": [0.5, 700]}",
        "{\"window\": [18446744073709551615, 700]}", "{\"loop\": \"yes\"}",
        "{\"background\": \"#12345g\"}", "{\"background\": \"red\"}", "{\"mode\": \"a\nb\"}"}) {
    const fs::path file = folder.write("player.json", text);
    Settings options;
    const auto read = read_settings(file, options);
    ASSERT_FALSE(read) << text;
    EXPECT_THAT(read.error().message, HasSubstr("player.json: "));
    EXPECT_EQ(read.error().message.find('\n'), std::string::npos) << read.error().message;
    EXPECT_EQ(options, Settings());
    if (text.find("\": ") == std::string::npos) {
      EXPECT_FALSE(write_settings(file, Settings(), changed_in_everything()));
      EXPECT_EQ(content(file), text);
    }
  }
}

TEST(Settings, folders_and_oversized_files_are_not_read) {
  const TemporaryFolder folder;
  Settings options;
  EXPECT_FALSE(read_settings(folder.path(), options));
  EXPECT_FALSE(read_settings("/dev/zero", options));
  const fs::path large = folder.write("player.json", std::string(70'000, ' ') + "{}");
  EXPECT_FALSE(read_settings(large, options));
}

TEST(Settings, a_file_that_cannot_be_written_is_an_error) {
  const TemporaryFolder folder;
  folder.write("file", "");
  const auto written =
      write_settings(folder / "file/player.json", Settings(), changed_in_everything());
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().message, HasSubstr("player.json: "));
}

TEST(Settings, a_symbolic_link_to_the_file_stays_a_link) {
  const TemporaryFolder folder;
  const fs::path file = folder.write("elsewhere/player.json", "{}");
  fs::create_symlink(file, folder / "player.json");
  ASSERT_TRUE(write_settings(folder / "player.json", Settings(), changed_in_everything()));
  EXPECT_TRUE(fs::is_symlink(folder / "player.json"));
  EXPECT_THAT(content(file), HasSubstr("\"point\""));
}

TEST(Settings, hostile_text_is_refused_or_gives_valid_values) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_settings(folder / "player.json", Settings(), changed_in_everything()));
  const std::string good = content(folder / "player.json");
  std::mt19937_64 random(7);
  int taken = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string text = good;
    for (int changes = static_cast<int>(random() % 3); changes >= 0; --changes)
      text[random() % text.size()] = static_cast<char>(random());
    Settings options;
    if (!parse_settings(text, options)) continue;
    ++taken;
    EXPECT_TRUE(options.size.x >= 64 && options.size.x <= 16384);
    EXPECT_TRUE(options.draw.edl >= 0.0f && options.draw.edl <= 100.0f);
    EXPECT_TRUE(options.delta >= 0.0 && options.delta <= 1.0);
    EXPECT_LT(static_cast<int>(options.draw.instancing),
              static_cast<int>(kEnumNames<Instancing>.size()));
  }
  EXPECT_GT(taken, 20);
  for (const char* key : {"mode", "unknown"}) {
    const std::string deep =
        fmt::format("{{\"{}\":{}{}}}", key, std::string(30'000, '['), std::string(30'000, ']'));
    Settings options;
    const auto parsed = parse_settings(deep, options);
    ASSERT_FALSE(parsed);
    EXPECT_THAT(parsed.error().message, HasSubstr("is nested too deep"));
  }
}

TEST(Settings, the_default_path_follows_xdg) {
  const Variable home("HOME", "/home/somebody");
  {
    const Variable config("XDG_CONFIG_HOME", "/elsewhere");
    EXPECT_EQ(default_settings_file(), "/elsewhere/pointreel/player.json");
  }
  {
    const Variable config("XDG_CONFIG_HOME", "relative");
    EXPECT_EQ(default_settings_file(), "/home/somebody/.config/pointreel/player.json");
  }
  const Variable config("XDG_CONFIG_HOME", nullptr);
  EXPECT_EQ(default_settings_file(), "/home/somebody/.config/pointreel/player.json");
  const Variable nobody("HOME", nullptr);
  EXPECT_EQ(default_settings_file(), "");
}

}  // namespace
}  // namespace pointreel::settings_test
