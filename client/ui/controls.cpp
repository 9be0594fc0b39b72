#include "client/ui/controls.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "client/scene/named_views.h"
#include "client/ui/time_text.h"

namespace pointreel {
namespace {

constexpr std::int64_t kSecond = 1'000'000;
constexpr double kFlySpeed = 0.6;  ///< radii of the scene per second
constexpr double kVolumeStep = 5.0;
constexpr double kFlyFast = 4.0;  ///< times as fast with shift

}  // namespace

void Controls::begin(Stage* stage, std::function<Camera()> home) {
  stage_ = stage;
  reel_ = nullptr;
  for (std::size_t i = 0; stage && i < stage->size() && !reel_; ++i) {
    reel_ = stage->reel(i);
    source_ = i;
  }
  home_ = std::move(home);
  moved_ = flying_ = false;
  loop_a_.reset();
  settings_.up = given_up_;
  if (stage_) camera_ = home_();
  set_prepare_options();
}

std::optional<std::string> Controls::take_said() { return std::exchange(said_, std::nullopt); }

bool Controls::act(Action action, Now now) {
  if (act_on_settings(action) || act_on_view(action)) return true;
  switch (action) {
    case Action::help:
      show_help = !show_help;
      return true;
    case Action::leave:
      if (!show_help && !flying_) return false;
      if (!std::exchange(show_help, false)) {
        flying_ = false;
        said_ = "no longer flying";
      }
      return true;
    case Action::add_camera_key:
    case Action::toggle_fullscreen:
    case Action::larger_interface:
    case Action::smaller_interface:
    case Action::screenshot:
    case Action::quit:
      return false;
    default:
      return act_on_time(action, now);
  }
}

bool Controls::act_on_settings(Action action) {
  Settings settings = settings_;
  switch (action) {
    case Action::next_mode:
      settings.draw.mode = next(settings.draw.mode);
      said_ = fmt::format("{}s", name(settings.draw.mode));
      break;
    case Action::next_instancing:
      settings.draw.instancing = next(settings.draw.instancing);
      said_ = fmt::format("instancing: {}", name(settings.draw.instancing));
      break;
    case Action::next_splatting:
      settings.draw.splatting = next(settings.draw.splatting);
      said_ = fmt::format("splatting: {}", name(settings.draw.splatting));
      break;
    case Action::quieter:
    case Action::louder:
      // Whoever asks for louder sound wants to hear it.
      settings.mute = settings.mute && action == Action::quieter;
      settings.volume = std::clamp(
          settings.volume + (action == Action::louder ? kVolumeStep : -kVolumeStep), 0.0, 100.0);
      said_ = fmt::format("volume {:.0f} %", settings.volume);
      break;
    case Action::toggle_mute:
      settings.mute = !settings.mute;
      said_ = settings.mute ? "sound off" : "sound on";
      break;
    case Action::toggle_floor:
      settings.floor = !settings.floor;
      break;
    case Action::toggle_drawing:
      settings.drawing_panel = !settings.drawing_panel;
      break;
    case Action::toggle_statistics:
      settings.statistics_panel = !settings.statistics_panel;
      break;
    default:
      return false;
  }
  set_settings(settings);
  return true;
}

bool Controls::act_on_view(Action action) {
  switch (action) {
    case Action::reset_view:
      if (stage_) camera_ = home_();
      moved_ = false;
      return true;
    case Action::view_front:
    case Action::view_back:
    case Action::view_left:
    case Action::view_right:
    case Action::view_top:
    case Action::view_bottom: {
      const NamedView& view = kNamedViews.at(static_cast<std::size_t>(action) -
                                             static_cast<std::size_t>(Action::view_front));
      if (!stage_) return true;
      camera_.yaw = view.yaw;
      camera_.pitch = view.pitch;
      moved_ = true;
      said_ = view.name;
      return true;
    }
    case Action::turn_over: {
      if (!stage_) return true;
      // The eye stays where the user has put it, and only the picture turns over.
      camera_.up = camera_.up.opposite();
      camera_.yaw = M_PI - camera_.yaw;
      camera_.pitch = -camera_.pitch;
      settings_.up = camera_.up;
      look_home_unless_moved();
      said_ = camera_.up.text() + " is up";
      return true;
    }
    case Action::toggle_fly:
      flying_ = stage_ != nullptr && !flying_;
      if (!flying_) said_ = "no longer flying";
      return true;
    default:
      return false;
  }
}

bool Controls::act_on_time(Action action, Now now) {
  if (!reel_) {
    if (stage_ && action == Action::toggle_play) {
      stage_->set_live_playing(!stage_->playing());
      said_ = stage_->playing() ? "live" : "paused";
    } else if (stage_) {
      said_ = "a live stream has no other time to go to";
    }
    return true;
  }
  switch (action) {
    case Action::toggle_play: {
      const bool play = !reel_->playing();
      stage_->for_each_reel([&](ReelPlayback& reel) { play ? reel.play(now) : reel.pause(now); });
      stage_->set_live_playing(play);
      break;
    }
    case Action::seek_forward:
      seek_by(5 * kSecond, now);
      break;
    case Action::seek_back:
      seek_by(-5 * kSecond, now);
      break;
    case Action::seek_forward_little:
      seek_by(kSecond, now);
      break;
    case Action::seek_back_little:
      seek_by(-kSecond, now);
      break;
    case Action::seek_forward_far:
      seek_by(60 * kSecond, now);
      break;
    case Action::seek_back_far:
      seek_by(-60 * kSecond, now);
      break;
    case Action::seek_forward_tenth:
    case Action::seek_back_tenth:
      stage_->for_each_reel([&](ReelPlayback& reel) {
        const auto tenth = static_cast<std::int64_t>(reel.timeline().duration_us / 10);
        reel.seek_by(action == Action::seek_forward_tenth ? tenth : -tenth, now);
      });
      said_ = time_text(now);
      break;
    case Action::seek_start:
      stage_->for_each_reel([&](ReelPlayback& reel) { reel.seek(0, now); });
      said_ = time_text(now);
      break;
    case Action::seek_last:
      stage_->for_each_reel([&](ReelPlayback& reel) {
        reel.pause(now);
        reel.seek(reel.timeline().times_us.back(), now);
      });
      said_ = time_text(now);
      break;
    case Action::step_forward:
    case Action::step_back:
      stage_->for_each_reel(
          [&](ReelPlayback& reel) { reel.step(action == Action::step_forward ? 1 : -1, now); });
      said_ = time_text(now);
      break;
    case Action::slower:
      set_speed(reel_->speed() / 1.1, now);
      break;
    case Action::faster:
      set_speed(reel_->speed() * 1.1, now);
      break;
    case Action::half_speed:
      set_speed(reel_->speed() / 2.0, now);
      break;
    case Action::double_speed:
      set_speed(reel_->speed() * 2.0, now);
      break;
    case Action::normal_speed:
      set_speed(1.0, now);
      break;
    case Action::turn_around:
      set_speed(-reel_->speed(), now);
      break;
    case Action::mark_loop:
      mark_loop(now);
      break;
    case Action::tell_time:
      said_ = time_text(now);
      break;
    case Action::toggle_loop: {
      const bool loop = !reel_->loop();
      settings_.loop = loop;
      stage_->for_each_reel([&](ReelPlayback& reel) { reel.set_loop(loop, now); });
      said_ = loop ? "loop" : "no loop";
      break;
    }
    default:
      return false;
  }
  return true;
}

std::string Controls::time_text(Now now) const {
  const Timeline& timeline = reel_->timeline();
  const std::uint64_t at = reel_->position_us(now);
  return fmt::format("{} / {}   frame {} of {}", format_time(at), format_time(timeline.duration_us),
                     timeline.shown_number(at), timeline.shown_count());
}

void Controls::seek_by(std::int64_t us, Now now) {
  stage_->for_each_reel([&](ReelPlayback& reel) { reel.seek_by(us, now); });
  said_ = time_text(now);
}

void Controls::set_speed(double speed, Now now) {
  stage_->for_each_reel([&](ReelPlayback& reel) { reel.set_speed(speed, now); });
  said_ = fmt::format("speed {:.2f}x", reel_->speed());
}

void Controls::scrub_to(std::uint64_t time_us, Now now) {
  if (!reel_) return;
  const double share =
      static_cast<double>(time_us) / static_cast<double>(reel_->timeline().duration_us);
  stage_->for_each_reel([&](ReelPlayback& reel) {
    reel.scrub_to(&reel == reel_ ? time_us
                                 : static_cast<std::uint64_t>(
                                       share * static_cast<double>(reel.timeline().duration_us)),
                  now);
  });
}

void Controls::scrub_end(Now now) {
  if (reel_) stage_->for_each_reel([&](ReelPlayback& reel) { reel.scrub_end(now); });
}

bool Controls::move(const Input& input, glm::ivec2 size, double seconds) {
  if (!stage_) return false;
  const Camera before = camera_;
  const double height = std::max(1, size.y);
  // A drag across the height of the picture is half a turn.
  if (input.orbit != glm::dvec2(0.0)) {
    const glm::dvec2 turn = input.orbit / height * M_PI;
    if (flying_)
      camera_.fly(glm::dvec3(0.0), -0.5 * turn.x, 0.5 * turn.y);
    else
      camera_.orbit(-turn.x, turn.y);
  }
  if (input.pan != glm::dvec2(0.0)) camera_.pan(-input.pan.x / height, input.pan.y / height);
  if (input.wheel != 0.0) {
    const glm::dvec2 share = input.cursor / glm::dvec2(glm::max(size, glm::ivec2(1)));
    camera_.zoom_at(std::pow(0.9, input.wheel), {2.0 * share.x - 1.0, 1.0 - 2.0 * share.y},
                    static_cast<double>(size.x) / height);
  }
  if (flying_ && input.fly != glm::dvec3(0.0)) {
    const double speed = kFlySpeed * camera_.scene_radius * (input.fast ? kFlyFast : 1.0);
    camera_.fly(input.fly * speed * seconds, 0.0, 0.0);
  }
  const bool changed = camera_ != before;
  moved_ = moved_ || changed;
  return changed;
}

void Controls::center_on(const glm::dvec3& point) {
  camera_.center_on(point);
  moved_ = true;
}

void Controls::look_home_unless_moved() {
  if (stage_ && !moved_) camera_ = home_();
}

void Controls::set_settings(const Settings& settings) {
  settings_ = settings;
  set_prepare_options();
}

void Controls::set_prepare_options() {
  if (stage_) stage_->set_prepare_options(prepare_options(settings_, stage_->prepare_options()));
}

/// Sets A the first time, then B, then clears both, as in mpv.
void Controls::mark_loop(Now now) {
  const std::uint64_t at = reel_->position_us(now);
  if (reel_->loop_range()) {
    stage_->for_each_reel([&](ReelPlayback& reel) { reel.set_loop_range(std::nullopt, now); });
    said_ = "no A-B loop";
  } else if (!loop_a_) {
    loop_a_ = at;
    said_ = "A-B loop: from " + format_time(at);
  } else {
    const auto [a, b] = std::minmax({*std::exchange(loop_a_, std::nullopt), at});
    if (a == b) {
      said_ = "no A-B loop";
      return;
    }
    stage_->for_each_reel([&](ReelPlayback& reel) { reel.set_loop_range(LoopRange{a, b}, now); });
    said_ = fmt::format("A-B loop: {} to {}", format_time(a), format_time(b));
  }
}

}  // namespace pointreel
