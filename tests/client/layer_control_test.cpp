#include "client/playback/layer_control.h"

#include <gtest/gtest.h>

namespace pointreel::layer_control_test {
namespace {

constexpr LayerRange kAll{0, 3, true, true};
constexpr double kFrame = 1.0 / 30.0;

LayerControl::Situation situation(double now, double fetched) {
  LayerControl::Situation situation;
  situation.now = now;
  situation.frame_seconds = kFrame;
  situation.fetched = fetched;
  situation.makeable = situation.made = 1.0;
  // The base without normals and with them, two layers, and three layers.
  situation.bytes = {6'000, 10'000, 40'000, 90'000};
  return situation;
}

LayerDecision chosen(const LayerControl& control, const LayerRange& top, Limit limit) {
  return decide(control.caps(), top, limit);
}

/// A reel that plays over a link with a buffer of two seconds, in steps of ten milliseconds.
struct Playing {
  LayerControl control{{3, 2, true}};
  double now = 0.0, buffered = 0.0, bits_per_second = 0.0;
  double speed = 1.0;
  double stalled = 0.0;
  int changes = 0;

  void step() {
    constexpr double kStep = 0.01;
    const double seconds = kFrame / speed, room = 2.0 - buffered;
    const auto before = control.rung();
    LayerControl::Situation now_is = situation(now, buffered / 2.0);
    now_is.frame_seconds = seconds;
    control.update(now_is);
    changes += control.rung() != before;
    const double frame_bytes = now_is.bytes[static_cast<std::size_t>(control.rung())];
    // The link is idle once the buffer is full.
    const double most = room / seconds * frame_bytes;
    const double bytes = std::min(bits_per_second / 8.0 * kStep, most);
    if (bytes > 0.0)
      control.carried(static_cast<std::uint64_t>(bytes), bytes / (bits_per_second / 8.0));
    buffered = std::min(2.0, buffered + bytes / frame_bytes * seconds);
    stalled += buffered < kStep ? kStep : 0.0;
    buffered = std::max(0.0, buffered - kStep);
    now += kStep;
  }
  void run(double bits, double seconds) {
    bits_per_second = bits;
    for (const double end = now + seconds; now < end;) step();
  }
};

TEST(RungLayers, ranges_from_a_base_without_normals_to_all_layers) {
  EXPECT_EQ(rung_layers(0, kAll), (LayerRange{0, 1, true, false}));
  EXPECT_EQ(rung_layers(1, kAll), (LayerRange{0, 1, true, true}));
  EXPECT_EQ(rung_layers(2, kAll), (LayerRange{0, 2, true, true}));
  EXPECT_EQ(rung_layers(3, kAll), kAll);
  EXPECT_EQ(rung_layers(9, kAll), kAll);
}

TEST(RungLayers, never_includes_attributes_or_layers_that_are_not_drawn) {
  EXPECT_EQ(rung_layers(3, {0, 2, true, false}), (LayerRange{0, 2, true, false}));
  EXPECT_EQ(rung_layers(0, {0, 3, false, true}), (LayerRange{0, 1, false, true}))
      << "all that there is of it";
}

TEST(LayerControl, begins_with_the_base_and_adds_layers_once_the_link_is_known_to_suffice) {
  Playing playing;
  EXPECT_EQ(chosen(playing.control, kAll, Limit::none),
            (LayerDecision{{0, 1, true, true}, Limit::link}));
  playing.run(100e6, 0.5);
  EXPECT_EQ(chosen(playing.control, kAll, Limit::none), (LayerDecision{kAll, Limit::none}));
  EXPECT_NEAR(playing.control.bytes_per_second(), 12.5e6, 1e5);
}

TEST(LayerControl, chooses_the_most_layers_that_a_link_can_carry) {
  // 30 frames a second of 10, 40 and 90 kB need 2.4, 9.6 and 21.6 Mbit/s.
  for (const auto& [bits, layers] :
       {std::pair{3e6, 1u}, {5e6, 1u}, {12e6, 2u}, {20e6, 2u}, {30e6, 3u}, {1e9, 3u}}) {
    Playing playing;
    playing.run(bits, 20.0);
    int as_expected = 0;
    for (int i = 0; i < 100; ++i) {
      playing.run(bits, 0.1);
      as_expected += chosen(playing.control, kAll, Limit::none).layers.end == layers;
    }
    EXPECT_GE(as_expected, 70) << bits << ": a higher rung is tried now and then";
  }
}

TEST(LayerControl, omits_normals_if_the_link_is_too_slow_even_for_the_base) {
  Playing playing;
  playing.run(1.7e6, 4.0);
  EXPECT_EQ(chosen(playing.control, kAll, Limit::none),
            (LayerDecision{{0, 1, true, false}, Limit::link}));
}

TEST(LayerControl, follows_a_changing_link_within_two_seconds_and_without_a_stall) {
  Playing playing;
  playing.run(100e6, 10.0);
  playing.stalled = 0.0;
  playing.run(5e6, 2.0);
  EXPECT_EQ(chosen(playing.control, kAll, Limit::none).layers.end, 1u);
  playing.changes = 0;
  playing.run(5e6, 18.0);
  EXPECT_LE(playing.changes, 8) << "a higher rung is tried ever more rarely";
  playing.run(100e6, 2.0);
  EXPECT_EQ(chosen(playing.control, kAll, Limit::none).layers.end, 3u);
  playing.changes = 0;
  playing.run(100e6, 10.0);
  EXPECT_EQ(playing.changes, 0);
  EXPECT_EQ(playing.stalled, 0.0);
}

TEST(LayerControl, trusts_a_full_buffer_more_than_a_low_measured_rate) {
  LayerControl control({3, 2, true});
  control.carried(1'000'000, 0.1);
  control.update(situation(0.0, 0.5));
  EXPECT_EQ(control.rung(), 3);
  for (int i = 0; i < 50; ++i) control.carried(20'000, 0.04);  // limited by round trips
  control.update(situation(1.0, 0.95));
  EXPECT_EQ(control.rung(), 3);
  control.update(situation(2.0, 0.6));
  EXPECT_LT(control.rung(), 3);
}

TEST(LayerControl, tries_more_than_the_measured_rate_while_the_buffer_stays_full) {
  LayerControl control({3, 2, true});
  control.carried(20'000, 0.04);  // 4 Mbit/s
  for (double now = 0.0; now < 0.9; now += 0.1) control.update(situation(now, 1.0));
  EXPECT_EQ(control.rung(), 1);
  for (double now = 1.0; now < 4.0; now += 0.1) control.update(situation(now, 1.0));
  EXPECT_EQ(control.rung(), 3);
}

TEST(LayerControl, requests_everything_while_paused) {
  LayerControl control({3, 2, true});
  control.carried(10'000, 0.1);
  LayerControl::Situation paused = situation(0.0, 0.0);
  paused.playing = false;
  control.update(paused);
  EXPECT_EQ(chosen(control, kAll, Limit::none), (LayerDecision{kAll, Limit::none}));
  EXPECT_EQ(chosen(control, {0, 2, true, false}, Limit::view),
            (LayerDecision{{0, 2, true, false}, Limit::view}));
}

TEST(LayerControl, requests_less_at_higher_speeds) {
  Playing playing;
  playing.run(30e6, 4.0);
  EXPECT_EQ(chosen(playing.control, kAll, Limit::none).layers.end, 3u);
  playing.speed = 2.0;
  playing.run(30e6, 4.0);
  EXPECT_EQ(chosen(playing.control, kAll, Limit::none).layers.end, 2u);
}

TEST(LayerControl, names_the_view_as_the_limit_if_the_link_could_carry_more) {
  Playing playing;
  playing.run(100e6, 1.0);
  EXPECT_EQ(chosen(playing.control, {0, 2, true, true}, Limit::view),
            (LayerDecision{{0, 2, true, true}, Limit::view}));
}

/// A machine without a link between it and the frames.
struct Machine {
  LayerControl control{{3, 2, false}};
  double now = 0.0;

  /// Plays frames that take `ms` each, whether they are ready or not.
  void run(std::uint32_t layers, double ms, double made, double seconds) {
    for (const double end = now + seconds; now < end; now += 0.02) {
      control.made(layers, ms);
      LayerControl::Situation is = situation(now, 1.0);
      is.made = made;
      control.update(is);
    }
  }
};

TEST(LayerControl, drops_a_layer_that_the_machine_prepares_too_slowly_and_restores_it_later) {
  Machine machine;
  machine.run(3, 130.0, 0.1, 1.5);
  EXPECT_EQ(chosen(machine.control, kAll, Limit::none),
            (LayerDecision{{0, 2, true, true}, Limit::machine}));
  machine.run(2, 40.0, 1.0, 5.0);
  EXPECT_EQ(machine.control.machine_layers(), 2u) << "three layers would take 90 ms";
  machine.run(2, 15.0, 1.0, 1.5);
  EXPECT_EQ(chosen(machine.control, kAll, Limit::none), (LayerDecision{kAll, Limit::none}));
}

TEST(LayerControl, restores_a_dropped_layer_ever_more_rarely_if_that_fails) {
  Machine machine;
  machine.run(3, 130.0, 0.1, 1.5);
  int taken_back = 0;
  for (const double end = machine.now + 60.0; machine.now < end;) {
    const bool all = machine.control.machine_layers() == 3;
    machine.run(all ? 3 : 2, all ? 130.0 : 10.0, all ? 0.1 : 1.0, 0.1);
    taken_back += !all && machine.control.machine_layers() == 3;
  }
  EXPECT_GE(taken_back, 2);
  EXPECT_LE(taken_back, 6);
}

TEST(LayerControl, keeps_its_layers_if_frames_are_prepared_quickly) {
  Machine machine;
  machine.run(3, 10.0, 0.1, 3.0);
  EXPECT_EQ(machine.control.machine_layers(), 3u);
}

TEST(LayerControl, never_drops_the_base) {
  Machine machine;
  for (const std::uint32_t layers : {3u, 2u, 1u}) machine.run(layers, 500.0, 0.0, 2.0);
  EXPECT_EQ(chosen(machine.control, kAll, Limit::none).layers.end, 1u);
  Playing playing;
  playing.run(1e3, 4.0);
  EXPECT_EQ(chosen(playing.control, kAll, Limit::none).layers.end, 1u);
}

TEST(LayerControl, does_not_limit_reels_of_plain_files) {
  LayerControl control({1, 2, true});
  LayerControl::Situation files = situation(0.0, 1.0);
  files.bytes.clear();
  control.update(files);
  EXPECT_EQ(chosen(control, {}, Limit::none).layers.end, 1u);
}

}  // namespace
}  // namespace pointreel::layer_control_test
