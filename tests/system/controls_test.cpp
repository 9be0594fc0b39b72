#include "client/ui/controls.h"

#include <memory>

#include <gmock/gmock.h>

#include "client/ui/time_text.h"
#include "tests/packed_reel.h"
#include "tests/wait.h"

namespace pointreel::controls_test {
namespace {

using testing::HasSubstr;

/// Controls of a reel of twenty frames at ten frames per second. Time stands still between calls.
class ControlsTest : public PackTest {
 protected:
  void SetUp() override {
    write_frames(20);
    Stage::Options options;
    options.source.fps = 10.0;
    auto stage = Stage::open({{frames_.string(), {}}}, options, home_for, [](auto&&...) {});
    ASSERT_TRUE(stage) << stage.error().message;
    stage_ = *std::move(stage);
    controls_.begin(stage_.get(), [this] { return home_for(stage_->bounds(), 'y'); });
    // Time stands still until the first frame has arrived.
    ASSERT_TRUE(wait_until([&] { return started(); }));
    act(Action::toggle_play);
    ASSERT_FALSE(reel().playing());
  }

  static Camera home_for(const Box& bounds, Up up) {
    Camera camera;
    camera.up = up;
    camera.frame_bounds(bounds, 1.5);
    return camera;
  }

  bool started() {
    stage_->update(now_);
    return reel().playing();
  }
  bool act(Action action) { return controls_.act(action, now_); }
  std::string said() { return controls_.take_said().value_or(""); }
  const ReelPlayback& reel() const { return *controls_.reel(); }
  std::uint32_t frame() const { return reel().timeline().frame_at(reel().position_us(now_)); }

  Clock::TimePoint now_ = std::chrono::steady_clock::now();
  std::unique_ptr<Stage> stage_;
  Controls controls_{Settings{}};
};

TEST_F(ControlsTest, play_pause_and_step_announce_the_time) {
  act(Action::step_forward);
  EXPECT_EQ(frame(), 1u);
  EXPECT_EQ(said(), "00:00.100 / 00:02.000   frame 2 of 20");
  EXPECT_EQ(said(), "") << "the announcement is made only once";
  act(Action::step_back);
  act(Action::step_back);
  EXPECT_EQ(frame(), 19u) << "the reel loops";
  act(Action::toggle_play);
  EXPECT_TRUE(reel().playing());
}

TEST_F(ControlsTest, seeks_move_by_the_amounts_of_their_keys) {
  act(Action::toggle_loop);  // otherwise it starts over at the end
  EXPECT_EQ(said(), "no loop");
  act(Action::seek_forward_tenth);
  EXPECT_EQ(reel().position_us(now_), 200'000u);
  act(Action::seek_back_tenth);
  EXPECT_EQ(reel().position_us(now_), 0u);
  act(Action::seek_forward_little);
  EXPECT_EQ(reel().position_us(now_), 1'000'000u);
  act(Action::seek_back_far);
  EXPECT_EQ(reel().position_us(now_), 0u);
  act(Action::seek_forward_little);
  act(Action::seek_start);
  EXPECT_EQ(reel().position_us(now_), 0u);
}

TEST_F(ControlsTest, home_goes_to_the_first_frame_and_end_pauses_at_the_last_one) {
  act(Action::toggle_play);
  act(Action::seek_last);
  EXPECT_EQ(frame(), 19u);
  EXPECT_FALSE(reel().playing()) << "the reel would loop and leave the last frame at once";
  EXPECT_EQ(said(), "00:01.900 / 00:02.000   frame 20 of 20");
  act(Action::toggle_play);
  act(Action::seek_start);
  EXPECT_EQ(frame(), 0u);
  EXPECT_TRUE(reel().playing());
}

TEST_F(ControlsTest, tell_time_announces_the_time_without_moving) {
  act(Action::step_forward);
  said();
  act(Action::tell_time);
  EXPECT_EQ(said(), "00:00.100 / 00:02.000   frame 2 of 20");
  EXPECT_EQ(frame(), 1u);
}

TEST_F(ControlsTest, speed_goes_up_down_and_back_to_normal) {
  act(Action::double_speed);
  EXPECT_EQ(said(), "speed 2.00x");
  act(Action::half_speed);
  act(Action::faster);
  EXPECT_NEAR(reel().speed(), 1.1, 1e-9);
  act(Action::turn_around);
  EXPECT_NEAR(reel().speed(), -1.1, 1e-9);
  act(Action::normal_speed);
  EXPECT_EQ(reel().speed(), 1.0);
}

TEST_F(ControlsTest, two_marks_set_an_a_b_loop_in_either_order) {
  act(Action::seek_forward_little);
  act(Action::mark_loop);
  EXPECT_EQ(controls_.loop_begin(), 1'000'000u);
  EXPECT_FALSE(reel().loop_range());
  act(Action::step_back);
  act(Action::step_back);
  act(Action::mark_loop);
  EXPECT_EQ(reel().loop_range(), (LoopRange{800'000, 1'000'000}));
  EXPECT_THAT(said(), HasSubstr("00:00.800 to 00:01.000"));
  EXPECT_FALSE(controls_.loop_begin());
  act(Action::mark_loop);
  EXPECT_FALSE(reel().loop_range());
  EXPECT_EQ(said(), "no A-B loop");
}

TEST_F(ControlsTest, two_marks_at_the_same_time_set_no_loop) {
  act(Action::mark_loop);
  act(Action::mark_loop);
  EXPECT_FALSE(reel().loop_range());
  EXPECT_FALSE(controls_.loop_begin());
}

TEST_F(ControlsTest, scrubbing_goes_to_the_frame_under_the_cursor) {
  controls_.scrub_to(1'550'000, now_);
  EXPECT_TRUE(controls_.scrubbing());
  EXPECT_EQ(frame(), 15u);
  controls_.scrub_end(now_);
  EXPECT_FALSE(controls_.scrubbing());
  EXPECT_FALSE(reel().playing()) << "it was paused before";
}

TEST_F(ControlsTest, drawing_actions_change_and_announce_the_settings) {
  act(Action::next_mode);
  EXPECT_EQ(controls_.settings().draw.mode, DrawMode::voxel);
  EXPECT_EQ(said(), "voxels");
  act(Action::toggle_floor);
  EXPECT_TRUE(controls_.settings().floor);
  const Splatting before = controls_.settings().draw.splatting;
  act(Action::next_splatting);
  EXPECT_NE(controls_.settings().draw.splatting, before);
  EXPECT_THAT(said(), HasSubstr(name(controls_.settings().draw.splatting)));
}

TEST_F(ControlsTest, input_turns_and_zooms_the_camera_and_reset_view_returns_home) {
  const Camera home = controls_.camera();
  EXPECT_FALSE(controls_.move({}, {600, 400}, 0.1)) << "there was no input";
  Input input;
  input.orbit = {200.0, 0.0};
  EXPECT_TRUE(controls_.move(input, {600, 400}, 0.1));
  EXPECT_NEAR(controls_.camera().yaw, -M_PI / 2, 1e-9) << "half the height turns by 90 degrees";
  input = {};
  input.wheel = 2.0;
  input.cursor = {300.0, 200.0};
  controls_.move(input, {600, 400}, 0.1);
  EXPECT_NEAR(controls_.camera().distance, 0.81 * home.distance, 1e-9);
  controls_.look_home_unless_moved();
  EXPECT_NE(controls_.camera(), home) << "the user has chosen a view";
  act(Action::reset_view);
  EXPECT_EQ(controls_.camera(), home);
}

TEST_F(ControlsTest, camera_follows_a_path_until_the_user_moves_it) {
  Camera path = controls_.camera();
  controls_.begin(stage_.get(), [&path] { return path; });
  path.yaw = 1.0;
  controls_.look_home_unless_moved();
  EXPECT_EQ(controls_.camera().yaw, 1.0);
  controls_.center_on({0.0, 0.5, 0.0});
  path.yaw = 2.0;
  controls_.look_home_unless_moved();
  EXPECT_EQ(controls_.camera().yaw, 1.0);
  act(Action::reset_view);
  controls_.look_home_unless_moved();
  EXPECT_EQ(controls_.camera().yaw, 2.0);
}

TEST_F(ControlsTest, flying_works_only_after_its_key) {
  Input input;
  input.fly = {0.0, 0.0, 1.0};
  EXPECT_FALSE(controls_.move(input, {600, 400}, 0.5));
  EXPECT_STREQ(controls_.unusual_keys(), "");
  act(Action::toggle_fly);
  EXPECT_TRUE(controls_.flying());
  EXPECT_THAT(controls_.unusual_keys(), HasSubstr("Q down"));
  const Camera before = controls_.camera();
  EXPECT_TRUE(controls_.move(input, {600, 400}, 0.5));
  const glm::dvec3 moved = controls_.camera().eye() - before.eye();
  EXPECT_LT(glm::dot(moved, before.axes()[2]), 0.0) << "forward is along the camera's view";
  input.fast = true;
  const Camera slow = controls_.camera();
  controls_.move(input, {600, 400}, 0.5);
  EXPECT_GT(glm::length(controls_.camera().eye() - slow.eye()), 2.0 * glm::length(moved));
  EXPECT_TRUE(act(Action::leave));
  EXPECT_FALSE(controls_.flying());
}

TEST_F(ControlsTest, leave_closes_one_thing_at_a_time) {
  act(Action::toggle_fly);
  act(Action::help);
  EXPECT_TRUE(act(Action::leave));
  EXPECT_FALSE(controls_.show_help);
  EXPECT_TRUE(controls_.flying());
  EXPECT_TRUE(act(Action::leave));
  EXPECT_FALSE(act(Action::leave)) << "only full screen is left";
}

TEST_F(ControlsTest, actions_of_the_window_are_left_to_the_window) {
  for (const Action action : {Action::quit, Action::screenshot, Action::toggle_fullscreen})
    EXPECT_FALSE(act(action));
}

TEST_F(ControlsTest, every_bound_action_is_harmless_without_a_stage) {
  Controls idle{Settings{}};
  for (const Binding& binding : bindings()) idle.act(binding.action, now_);
  EXPECT_EQ(idle.reel(), nullptr);
  EXPECT_FALSE(idle.flying());
  EXPECT_FALSE(idle.move({}, {600, 400}, 0.1));
}

TEST(LiveControls, pause_and_resume_but_cannot_seek) {
  // No server listens there: the stage opens first and connects in the background.
  auto stage = Stage::open(
      {{"ws://127.0.0.1:9/live/me", {}}}, {}, [](auto&&...) { return Camera{}; }, [](auto&&...) {});
  ASSERT_TRUE(stage) << stage.error().message;
  Controls controls{Settings{}};
  controls.begin(stage->get(), [] { return Camera{}; });
  const Clock::TimePoint now{};
  EXPECT_EQ(controls.reel(), nullptr);
  EXPECT_TRUE(controls.playing());
  controls.act(Action::toggle_play, now);
  EXPECT_FALSE(controls.playing());
  EXPECT_EQ(controls.take_said(), "paused");
  controls.act(Action::toggle_play, now);
  EXPECT_TRUE(controls.playing());
  EXPECT_EQ(controls.take_said(), "live");
  controls.act(Action::seek_forward, now);
  EXPECT_EQ(controls.take_said(), "a live stream has no other time to go to");
}

TEST(TimeText, has_hours_only_if_there_are_any) {
  EXPECT_EQ(format_time(0), "00:00.000");
  EXPECT_EQ(format_time(61'234'999), "01:01.234");
  EXPECT_EQ(format_time(3'600'000'000), "1:00:00.000");
}

TEST_F(ControlsTest, the_view_keys_look_from_the_six_sides_at_the_same_place) {
  const Camera home = controls_.camera();
  const std::pair<Action, glm::dvec3> sides[] = {
      {Action::view_front, {0, 0, 1}}, {Action::view_back, {0, 0, -1}},
      {Action::view_left, {-1, 0, 0}}, {Action::view_right, {1, 0, 0}},
      {Action::view_top, {0, 1, 0}},   {Action::view_bottom, {0, -1, 0}}};
  for (const auto& [action, side] : sides) {
    EXPECT_TRUE(act(action));
    const Camera camera = controls_.camera();
    EXPECT_LT(glm::distance(camera.axes()[2], side), 1e-9) << said();
    EXPECT_EQ(camera.target, home.target);
    EXPECT_EQ(camera.distance, home.distance);
  }
  controls_.look_home_unless_moved();
  EXPECT_NE(controls_.camera(), home) << "the user has chosen the view";
  act(Action::reset_view);
  EXPECT_EQ(controls_.camera(), home);
}

TEST_F(ControlsTest, turning_over_reverses_the_axis_that_points_up_until_something_else_plays) {
  const auto up = [&] { return controls_.camera().axes()[1].y; };
  act(Action::view_front);
  EXPECT_GT(up(), 0.9);
  const glm::dvec3 eye = controls_.camera().eye();
  act(Action::turn_over);
  EXPECT_EQ(said(), "-y is up");
  EXPECT_LT(up(), -0.9);
  EXPECT_LT(glm::distance(controls_.camera().eye(), eye), 1e-6) << "it is seen from the same side";
  EXPECT_EQ(controls_.settings().up, Up('y', true));
  act(Action::turn_over);
  EXPECT_EQ(said(), "y is up");
  EXPECT_GT(up(), 0.9);
  act(Action::turn_over);
  controls_.begin(stage_.get(), [this] { return home_for(stage_->bounds(), 'y'); });
  EXPECT_EQ(controls_.settings().up, std::nullopt);
}

}  // namespace
}  // namespace pointreel::controls_test
