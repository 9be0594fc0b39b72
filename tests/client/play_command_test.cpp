#include "client/app/play_command.h"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/options/option_table.h"
#include "client/options/option_text.h"
#include "client/session/stage_setup.h"
#include "common/command_line/option_words.h"
#include "tests/temporary_folder.h"

namespace pointreel::play_command_test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// `pointreel play reel` with more arguments.
class PlayCommandTest : public testing::Test {
 protected:
  Result<PlayOptions> parse(std::vector<std::string> arguments) {
    app_ = std::make_unique<cli::Program>();
    command_ = std::make_unique<PlayCommand>(*app_);
    app_->add_common_options();
    arguments.insert(arguments.begin(), {"play", "reel"});
    if (const auto parsed = app_->parse(arguments); !parsed) return tl::unexpected(parsed.error());
    return command_->options();
  }
  /// What is wrong with these arguments.
  std::string error(const std::vector<std::string>& arguments) {
    const auto options = parse(arguments);
    return options ? "nothing" : options.error().message;
  }

  const TemporaryFolder folder_;
  std::unique_ptr<PlayCommand> command_;
  std::unique_ptr<cli::Program> app_;  ///< ends first
};

TEST_F(PlayCommandTest, without_options_everything_is_at_its_default) {
  const auto options = parse({});
  ASSERT_TRUE(options) << options.error().message;
  EXPECT_EQ(options->settings, Settings{});
  ASSERT_EQ(options->sources.size(), 1u);
  EXPECT_EQ(options->sources[0].where, "reel");
  EXPECT_FALSE(options->offscreen || options->view || options->camera_path);
  EXPECT_EQ(options->picture_size(), glm::ivec2(1280, 720));
}

TEST_F(PlayCommandTest, options_of_the_table_go_into_the_settings) {
  const auto options =
      parse({"--mode", "voxel", "--edl", "0.5", "--background", "#ff0080", "--no-lighting",
             "--floor", "--drafts", "moving", "--no-loop", "--pixel-size", "3"});
  ASSERT_TRUE(options) << options.error().message;
  Settings expected;
  expected.draw.mode = DrawMode::voxel;
  expected.draw.edl = 0.5f;
  expected.draw.background = *parse_color("#ff0080");
  expected.draw.lighting = false;
  expected.draw.pixel_size = 3.0f;
  expected.floor = true;
  expected.drafts = Drafts::moving;
  expected.loop = false;
  EXPECT_EQ(options->settings, expected);
}

TEST_F(PlayCommandTest, the_last_of_two_flags_counts) {
  EXPECT_EQ(parse({"--loop", "--no-loop"})->settings.loop, false);
  EXPECT_EQ(parse({"--no-loop", "--loop"})->settings.loop, true);
}

TEST_F(PlayCommandTest, delta_is_an_earlier_name_of_voxel_merge) {
  EXPECT_EQ(parse({"--voxel-merge", "0.25"})->settings.delta, 0.25);
  EXPECT_EQ(parse({"--delta", "0.25"})->settings.delta, 0.25);
  EXPECT_THAT(error({"--delta", "2"}), HasSubstr("not a number from 0 to 1"));
  EXPECT_THAT(error({"--delta", "0.1", "--voxel-merge", "0.2"}), HasSubstr("excludes"));
}

TEST_F(PlayCommandTest, wrong_values_are_errors_that_say_what_is_accepted) {
  EXPECT_THAT(error({"--mode", "disc"}), HasSubstr("not one of surfel, voxel, point"));
  EXPECT_THAT(error({"--edl", "nan"}), HasSubstr("not a number from 0 to 100"));
  EXPECT_THAT(error({"--background", "red"}), HasSubstr("not a colour such as #1c1f24"));
  EXPECT_THAT(error({"--speed", "0"}), HasSubstr("0.1 to 4 or -4 to -0.1"));
  EXPECT_THAT(error({"--offscreen", "1280"}), HasSubstr("not a size such as 1280x720"));
  EXPECT_THAT(error({"--offscreen", "1280x16385"}), HasSubstr("from 1 to 16384"));
  EXPECT_THAT(error({"--camera", "above"}), HasSubstr("not a view"));
  EXPECT_THAT(error({"--at-position", "1,2"}), HasSubstr("not a position"));
  EXPECT_THAT(error({"--at", "-1"}), HasSubstr("not a number"));
  EXPECT_THAT(error({"--record", "out.mp4"}), HasSubstr("--offscreen"));
  EXPECT_THAT(error({"--at-position", "1,2,3", "--at-position", "1,2,3"}),
              HasSubstr("2 times for 1 source"));
}

TEST_F(PlayCommandTest, a_picture_is_png_or_refused) {
  EXPECT_EQ(parse({"--screenshot", "x.PNG"})->screenshot, "x.PNG");
  for (const char* name : {"x.jpg", "x", ".png.txt"})
    EXPECT_THAT(error({"--screenshot", name}), HasSubstr("does not end in .png"));
  EXPECT_THAT(error({"--offscreen", "64x64", "--record", "out-%04d.jpg"}),
              HasSubstr("does not end in .png"));
  EXPECT_EQ(parse({"--offscreen", "64x64", "--record", "out-%04d.png"})->record, "out-%04d.png");
}

TEST_F(PlayCommandTest, redirects_to_other_hosts_are_followed_only_if_told_so) {
  EXPECT_FALSE(parse({})->follow_redirects);
  EXPECT_TRUE(parse({"--follow-redirects"})->follow_redirects);
}

TEST_F(PlayCommandTest, speeds_backward_are_accepted) {
  EXPECT_EQ(parse({"--speed", "-0.5"})->speed, -0.5);
  EXPECT_EQ(parse({"--speed", "4"})->speed, 4.0);
}

TEST_F(PlayCommandTest, every_axis_can_point_up_in_either_direction) {
  EXPECT_EQ(parse({})->settings.up, std::nullopt);
  EXPECT_EQ(parse({"--up", "z"})->settings.up, Up('z'));
  EXPECT_EQ(parse({"--up", "-y"})->settings.up, Up('y', true));
  EXPECT_EQ(parse({"--up=-x"})->settings.up, Up('x', true));
  EXPECT_THAT(error({"--up", "w"}), HasSubstr("\"w\" is not one of x, -x, y, -y, z, -z"));
  const auto file = folder_.write("player.json", R"({"mode": "point"})");
  auto options = parse({"--up", "-z", "--config", file.string()});
  ASSERT_TRUE(options && command_->read_settings(*options));
  EXPECT_EQ(options->settings.up, Up('z', true));
  EXPECT_EQ(options->settings.draw.mode, DrawMode::point);
}

TEST_F(PlayCommandTest, a_camera_is_a_name_or_angles_or_a_path) {
  EXPECT_NEAR(parse({"--camera", "left"})->view->yaw, -M_PI / 2, 1e-12);
  EXPECT_NEAR(parse({"--view", "30,-90"})->view->pitch, -M_PI / 2, 1e-12);
  EXPECT_THAT(error({"--camera", "0,91"}), HasSubstr("not a view"));
  const auto file = folder_.write(
      "path.json", R"({"pointreel_camera_path": 1, "keys": [{"seconds": 1, "yaw": 90}]})");
  const auto options = parse({"--camera", file.string()});
  ASSERT_TRUE(options) << options.error().message;
  ASSERT_TRUE(options->camera_path);
  EXPECT_EQ(options->camera_path->keys.size(), 1u);
}

TEST_F(PlayCommandTest, ways_of_opengl_do_not_go_with_the_software_renderer) {
  EXPECT_EQ(error({"--instancing", "geometry"}), "nothing");
  EXPECT_THAT(error({"--instancing", "geometry", "--renderer", "software"}),
              HasSubstr("does nothing with --renderer software"));
}

TEST_F(PlayCommandTest, a_close_view_has_a_target_and_a_zoom) {
  const Box person{{-0.5, 0.0, -0.5}, {0.5, 2.0, 0.5}};
  const auto seen = [&](const std::vector<std::string>& arguments, Up up) {
    return first_camera(parse(arguments).value(), person, up, {640, 480});
  };
  const Camera whole = seen({}, 'y');
  const Camera head = seen({"--target", "head", "--zoom", "4"}, 'y');
  EXPECT_NEAR(head.target.y, 1.84, 1e-9);
  EXPECT_NEAR(head.distance, whole.distance / 4.0, 1e-9);
  EXPECT_NEAR(seen({"--target", "head"}, {'y', true}).target.y, 0.16, 1e-9);
  EXPECT_EQ(seen({"--target", "0.1,-2,3"}, 'y').target, glm::dvec3(0.1, -2.0, 3.0));
  EXPECT_EQ(seen({"--target", "middle"}, 'y'), whole);
  EXPECT_THAT(error({"--target", "hand"}), HasSubstr("feet, middle or head"));
  EXPECT_NE(error({"--zoom", "0"}), "nothing");
  const Camera near = seen({"--target", "head", "--distance", "0.3"}, 'y');
  EXPECT_EQ(near.target, head.target);
  EXPECT_DOUBLE_EQ(near.distance, 0.3);
  EXPECT_NE(error({"--zoom", "4", "--distance", "0.3"}), "nothing");
}

TEST_F(PlayCommandTest, the_command_line_wins_over_the_settings_file) {
  const auto file =
      folder_.write("player.json", R"({"edl": 0.5, "pixel_size": 3, "mode": "point"})");
  auto options = parse({"--edl", "2", "--pixel-size", "1", "--config", file.string()});
  ASSERT_TRUE(options) << options.error().message;
  ASSERT_TRUE(command_->read_settings(*options));
  EXPECT_EQ(options->settings.draw.edl, 2.0f);
  EXPECT_EQ(options->settings.draw.pixel_size, 1.0f);
  EXPECT_EQ(options->settings.draw.mode, DrawMode::point);
  EXPECT_EQ(options->settings_file, file.string());
}

TEST_F(PlayCommandTest, a_wrong_value_in_the_file_is_an_error_even_if_the_command_line_wins) {
  const auto file = folder_.write("player.json", R"({"edl": -1, "mode": "point"})");
  auto options = parse({"--edl", "2", "--config", file.string()});
  ASSERT_TRUE(options) << options.error().message;
  EXPECT_FALSE(command_->read_settings(*options));
  EXPECT_EQ(options->settings.draw.edl, 2.0f);
  EXPECT_EQ(options->settings.draw.mode, DrawMode::surfel);
  EXPECT_EQ(options->settings_file, "");
}

TEST_F(PlayCommandTest, offscreen_reads_only_a_file_that_is_named_and_keeps_its_size) {
  const auto file = folder_.write("player.json", R"({"window": [800, 600], "mode": "voxel"})");
  auto options = parse({"--offscreen", "64x32"});
  ASSERT_TRUE(options && command_->read_settings(*options));
  EXPECT_EQ(options->settings_file, "");
  options = parse({"--offscreen", "64x32", "--config", file.string()});
  ASSERT_TRUE(options && command_->read_settings(*options));
  EXPECT_EQ(options->settings.draw.mode, DrawMode::voxel);
  EXPECT_EQ(options->picture_size(), glm::ivec2(64, 32));
  options = parse({"--config", file.string(), "--no-config"});
  ASSERT_TRUE(options && command_->read_settings(*options));
  EXPECT_EQ(options->settings, Settings{});
}

TEST_F(PlayCommandTest, help_shows_every_option_of_the_table_with_its_default_in_80_columns) {
  ASSERT_TRUE(parse({}));
  const std::string help = app_->subcommands().front().help_all();
  for (const Option& option : option_table()) {
    if (option.help.empty()) continue;
    EXPECT_THAT(help, HasSubstr(command_line_name(option.name)));
    if (std::holds_alternative<Option::Flag>(option.value)) continue;
    EXPECT_THAT(help, HasSubstr(value_text(option, {})));
  }
  EXPECT_THAT(help, Not(HasSubstr("--delta")));
  EXPECT_THAT(help, HasSubstr("--loop, --no-loop "));
  std::size_t begin = 0;
  for (std::size_t end; (end = help.find('\n', begin)) != std::string::npos; begin = end + 1)
    EXPECT_LE(end - begin, 80u) << help.substr(begin, end - begin);
}

TEST(Help, says_what_an_option_accepts_without_the_names_of_types) {
  cli::Program app("An app.\nMore about it.", "app");
  int number = 5;
  double share = 0.0;
  std::string word = "one", place, file, named;
  app.add_option("--number", number, "a number").check(cli::range(0, 21)).capture_default_str();
  app.add_option("--share", share, "a share (of all)").check(cli::range(0.0, 1e9));
  app.add_option("--word", word, "a word").check(cli::one_of({"one", "two"})).capture_default_str();
  app.add_option("--place", place, "a place").type_name("HOST:PORT").required();
  app.add_option("--file", file, "ldc: a file").type_name("FILE.pem").check(cli::existing_file());
  app.add_option("--named", named, "a name").envname("NAMED");
  app.add_common_options();
  const std::string help = app.help();
  for (const char* line :
       {"--number N              A number (0 to 21; default 5)\n",
        "--share NUMBER          A share (of all; 0 to 1000000000)\n",
        "--word NAME             A word (one, two; default one)\n",
        "--place HOST:PORT       A place (required)\n", "--file FILE.pem         ldc: a file\n",
        "--named TEXT            A name (or NAMED in the environment)\n"})
    EXPECT_THAT(help, HasSubstr(line)) << help;
}

TEST(Wrap, breaks_between_words_only) {
  EXPECT_EQ(cli::wrap("one two three", 7), "one two\nthree");
  EXPECT_EQ(cli::wrap("incomprehensibilities", 7), "incomprehensibilities");
  EXPECT_EQ(cli::wrap("", 7), "");
}

TEST_F(PlayCommandTest, colours_may_be_those_of_a_scalar_field) {
  const auto options = parse({"--color", "scan angle", "--color-range", "-5,2.5"});
  ASSERT_TRUE(options) << options.error().message;
  EXPECT_EQ(options->settings.draw.color, ColorSource::colors);
  EXPECT_EQ(options->settings.scalar, (ScalarChoice{"scan angle", glm::dvec2(-5, 2.5)}));
  EXPECT_TRUE(parse({"--color", "normals"})->settings.scalar.field.empty());
  EXPECT_THAT(error({"--color", std::string(65, 'a')}), HasSubstr("is not one of"));
  EXPECT_THAT(error({"--color-range", "0,1"}), HasSubstr("needs --color"));
  EXPECT_THAT(error({"--color", "normals", "--color-range", "0,1"}), HasSubstr("needs --color"));
  for (const char* range : {"1,0", "1,1", "nan,1", "1", "1,2,3", "0,inf"})
    EXPECT_THAT(error({"--color", "a", "--color-range", range}), HasSubstr("two numbers")) << range;
}

}  // namespace
}  // namespace pointreel::play_command_test
