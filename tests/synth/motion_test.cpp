#include "datasets_synthetic/motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "datasets_synthetic/body.h"
#include "datasets_synthetic/motions/flight.h"
#include "datasets_synthetic/motions/motions.h"
#include "datasets_synthetic/motions/track.h"
#include "datasets_synthetic/surface_grid.h"

namespace pointreel::motion_test {
namespace {

Frame frame_of(const Skeleton& frames, Bone bone) { return frames[static_cast<std::size_t>(bone)]; }

double degrees_between(const glm::dvec3& a, const glm::dvec3& b) {
  const double c = glm::dot(a, b) / (glm::length(a) * glm::length(b));
  return std::acos(std::clamp(c, -1.0, 1.0)) * 180.0 / 3.14159265358979;
}

/// One test for each motion.
class EveryMotion : public testing::TestWithParam<std::string> {
 protected:
  const Motion& motion() const { return *find_motion(GetParam()); }
  Pose pose(int number) const { return motion().pose(number / kPosesPerSecond); }
  Skeleton frames(int number) const { return skeleton(pose(number)); }
};
std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const Motion& motion : motions()) all.emplace_back(motion.name);
  return all;
}
INSTANTIATE_TEST_SUITE_P(Motion, EveryMotion, testing::ValuesIn(names()), [](const auto& one) {
  std::string name = one.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST(Motions, include_the_five_of_the_paper_and_a_walk) {
  std::vector<std::pair<std::string_view, int>> all;
  for (const Motion& motion : motions()) all.emplace_back(motion.name, motion.poses);
  EXPECT_EQ(all, (std::vector<std::pair<std::string_view, int>>{{"baseball", 115},
                                                                {"basketball", 114},
                                                                {"kick", 150},
                                                                {"soccer-juggle", 116},
                                                                {"soccer-shoot", 60},
                                                                {"walk", 60}}));
}

TEST_P(EveryMotion, has_a_pose_at_any_time) {
  const auto same = [](const Pose& a, const Pose& b) {
    double apart = glm::length(a.offset - b.offset);
    for (std::size_t i = 0; i < kBoneCount; ++i) {
      for (int column = 0; column < 3; ++column) {
        apart = std::max(apart, glm::length(a.turns[i][column] - b.turns[i][column]));
      }
    }
    return apart < 1e-6 && a.ball.has_value() == b.ball.has_value();
  };
  const double end = motion().seconds();
  EXPECT_FALSE(same(pose(0), pose(motion().poses / 2)));
  if (motion().loops) {
    EXPECT_TRUE(same(motion().pose(-end), pose(0)));
    EXPECT_TRUE(same(motion().pose(0.3), motion().pose(0.3 + 2.0 * end)));
  } else {
    EXPECT_TRUE(same(motion().pose(-1.0), pose(0)));
    EXPECT_TRUE(same(motion().pose(end + 5.0), pose(motion().poses - 1)));
  }
}

TEST_P(EveryMotion, is_the_same_on_every_call) {
  for (const int number : {0, 17, 42}) {
    const Body a = pose_body(pose(number)), b = pose_body(pose(number));
    for (std::size_t i = 0; i < kFrameCount; ++i) {
      EXPECT_EQ(a.frames[i].joint, b.frames[i].joint);
      EXPECT_EQ(a.frames[i].axes, b.frames[i].axes);
    }
  }
}

TEST_P(EveryMotion, turns_bones_without_bending_or_mirroring_them) {
  for (int number = 0; number < motion().poses; ++number) {
    const Skeleton now = frames(number);
    for (const Frame& frame : now) {
      const glm::dmat3 square = glm::transpose(frame.axes) * frame.axes;
      for (int column = 0; column < 3; ++column) {
        EXPECT_LT(glm::length(square[column] - glm::dmat3(1.0)[column]), 1e-9);
      }
      EXPECT_GT(glm::determinant(frame.axes), 0.0);
    }
    // A joint that two bones share is at the same place for both bones.
    const auto place = [&](Bone bone, Bone joint) {
      return frame_of(now, bone).place(frame_of(now, joint).rest_joint);
    };
    for (const auto& [bone, child] : {std::pair{Bone::left_thigh, Bone::left_shin},
                                      {Bone::right_shin, Bone::right_foot},
                                      {Bone::left_upper_arm, Bone::left_forearm},
                                      {Bone::right_forearm, Bone::right_hand},
                                      {Bone::chest, Bone::neck},
                                      {Bone::pelvis, Bone::left_thigh}}) {
      EXPECT_LT(glm::length(place(bone, child) - frame_of(now, child).joint), 1e-9);
    }
  }
}

TEST_P(EveryMotion, bends_joints_only_as_people_can) {
  const glm::dvec3 down(0, -1, 0);
  for (int number = 0; number < motion().poses; ++number) {
    const Pose now = pose(number);
    for (const bool left : {true, false}) {
      // Where the turns of knee and elbow take the hanging bone.
      const glm::dvec3 shin = now[left ? Bone::left_shin : Bone::right_shin] * down;
      const glm::dvec3 forearm = now[left ? Bone::left_forearm : Bone::right_forearm] * down;
      EXPECT_LT(shin.z, 0.06) << number << " a knee bends forwards";
      EXPECT_LT(std::abs(shin.x), 0.05) << number;
      EXPECT_LT(degrees_between(shin, down), 150.0) << number;
      EXPECT_GT(forearm.z, -0.06) << number << " an elbow bends backwards";
      EXPECT_LT(degrees_between(forearm, down), 155.0) << number;
      const glm::dmat3& foot = now[left ? Bone::left_foot : Bone::right_foot];
      EXPECT_LT(degrees_between(foot[1], {0, 1, 0}), 65.0) << number << " an ankle";
      const glm::dvec3 thigh = now[left ? Bone::left_thigh : Bone::right_thigh] * down;
      EXPECT_LT(degrees_between(thigh, glm::dvec3(0, -0.5, 0.85)), 115.0) << number << " a hip";
    }
    const Skeleton all = skeleton(now);
    const auto front = [&](Bone bone) { return frame_of(all, bone).axes[2]; };
    EXPECT_LT(degrees_between(front(Bone::chest), front(Bone::pelvis)), 60.0) << number;
    EXPECT_LT(degrees_between(front(Bone::head), front(Bone::chest)), 80.0) << number;
  }
}

TEST_P(EveryMotion, moves_no_joint_faster_than_people_do) {
  Skeleton before = frames(0);
  const int count = motion().poses + (motion().loops ? 1 : 0);
  for (int number = 1; number < count; ++number) {
    const Skeleton now = frames(number);
    for (std::size_t i = 0; i < kBoneCount; ++i) {
      const Bone bone = static_cast<Bone>(i);
      const bool trunk = bone <= Bone::head;
      const double speed = glm::length(now[i].joint - before[i].joint) * kPosesPerSecond;
      EXPECT_LT(speed, trunk ? 4.0 : 13.0) << number << " bone " << i;  // m/s
      EXPECT_LT(degrees_between(now[i].axes[1], before[i].axes[1]), 75.0)
          << number << " bone " << i;
    }
    before = now;
  }
}

/// The balls of a foot that touch the floor: the heel and the ball of the foot.
struct Sole {
  glm::dvec3 heel, ball;  // their lowest points
};
Sole sole(const Skeleton& frames, bool left) {
  const Frame foot = frame_of(frames, left ? Bone::left_foot : Bone::right_foot);
  const double side = left ? 1.0 : -1.0;
  return {foot.place({side * 0.088, 0.044, -0.045}) - glm::dvec3(0, 0.044, 0),
          foot.place({side * 0.095, 0.036, 0.12}) - glm::dvec3(0, 0.036, 0)};
}

TEST_P(EveryMotion, neither_floats_nor_sinks) {
  const bool jumps = GetParam() == "basketball";
  int in_the_air = 0;
  for (int number = 0; number < motion().poses; ++number) {
    Pose alone = pose(number);
    alone.ball.reset();
    alone.bat.reset();
    const double lowest = bounds(pose_body(alone).surface).min.y;
    EXPECT_GT(lowest, -0.03) << number;  // the bounds include fillets, which adds 12 mm
    if (lowest > 0.02) ++in_the_air;
  }
  if (jumps) {
    EXPECT_GE(in_the_air, 9);  // 0.4 s
    EXPECT_LE(in_the_air, 14);
  } else {
    EXPECT_EQ(in_the_air, 0);
  }
}

TEST_P(EveryMotion, does_not_slide_on_its_feet) {
  if (GetParam() == "walk") return;  // its feet have to slide, as it walks on the spot
  for (int number = 1; number < motion().poses; ++number) {
    const Skeleton before = frames(number - 1), now = frames(number);
    for (const bool left : {true, false}) {
      const Sole a = sole(before, left), b = sole(now, left);
      const auto slides = [](const glm::dvec3& from, const glm::dvec3& to) {
        const bool stands = from.y < 0.004 && to.y < 0.004;
        return stands ? glm::length(to - from) : 1.0;
      };
      const double least = std::min(slides(a.heel, b.heel), slides(a.ball, b.ball));
      if (least < 1.0) {
        EXPECT_LT(least, 0.02) << number << (left ? " left" : " right");
      }
    }
  }
}

TEST_P(EveryMotion, lets_its_ball_fly_by_gravity_while_nothing_touches_it) {
  constexpr double kStep = 1.0 / 90.0;
  const int steps = static_cast<int>(motion().seconds() / kStep) - 1;
  int flying = 0, touched = 0;
  const auto ball_at = [&](int step) { return motion().pose(step * kStep).ball; };
  std::optional<Ball> before = ball_at(0), now = ball_at(1);
  for (int step = 1; step < steps; ++step) {
    const std::optional<Ball> after = ball_at(step + 1);
    if (before && now && after) {
      Pose alone = motion().pose(step * kStep);
      alone.ball.reset();
      const double size = radius(now->kind);
      const Body body = pose_body(alone);
      const SurfaceDistance nearest = distance_to(body.surface, now->center);
      const double gap = nearest.distance.value - size;
      EXPECT_GT(gap, -0.01) << step * kStep << " s: the ball is deep inside bone "
                            << static_cast<int>(body.parts[nearest.primitive].bone);
      EXPECT_GT(now->center.y, size - 0.001) << step * kStep << " s: the ball is inside the floor";
      const glm::dvec3 acceleration =
          (after->center - 2.0 * now->center + before->center) / (kStep * kStep);
      if (glm::length(acceleration - glm::dvec3(0, -kGravity, 0)) < 0.05) {
        ++flying;
      } else {
        // A contact between two steps lies within the distance that the ball moves in one step.
        const double speed = std::max(glm::length(after->center - now->center),
                                      glm::length(now->center - before->center));
        EXPECT_LT(std::min(gap, now->center.y - size), 0.02 + speed) << step * kStep << " s";
        ++touched;
      }
    }
    before = now;
    now = after;
  }
  if (flying + touched > 0) {
    EXPECT_GT(flying, 2);
    EXPECT_GT(touched, 0);
  }
}

TEST_P(EveryMotion, stays_within_the_scanned_volume) {
  for (int number = 0; number < motion().poses; ++number) {
    const glm::dvec3 extent = bounds(pose_body(pose(number)).surface).extent();
    EXPECT_LT(std::max({extent.x, extent.y, extent.z}), 2.35) << number;
    EXPECT_GT(extent.y, 1.3) << number;
  }
}

TEST_P(EveryMotion, has_few_enough_parts_to_be_sampled_quickly) {
  for (const int number : {0, motion().poses / 3, motion().poses / 2}) {
    const Body body = pose_body(pose(number));
    EXPECT_LE(body.surface.primitives.size(), 90u);
    const auto grid = SurfaceGrid::build(body.surface);  // fails if too many meet in one place
    EXPECT_TRUE(grid) << grid.error().message;
  }
}

TEST(Tracks, pass_through_their_keys_and_never_beyond_them) {
  constexpr Track<1, 5> keys = {
      {{0.0, {1.0}}, {1.0, {1.0}}, {1.5, {3.0}}, {3.0, {4.0}}, {4.0, {0.0}}}};
  for (const auto& key : keys) EXPECT_DOUBLE_EQ(at(keys, key.time)[0], key.value[0]);
  for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
    const double low = std::min(keys[i].value[0], keys[i + 1].value[0]);
    const double high = std::max(keys[i].value[0], keys[i + 1].value[0]);
    for (double s = 0.0; s < 1.0; s += 0.05) {
      const double value = at(keys, keys[i].time + s * (keys[i + 1].time - keys[i].time))[0];
      EXPECT_GE(value, low - 1e-12);
      EXPECT_LE(value, high + 1e-12);
    }
    const double time = keys[i + 1].time, h = 1e-5;
    const double left = (at(keys, time)[0] - at(keys, time - h)[0]) / h;
    const double right = (at(keys, time + h)[0] - at(keys, time)[0]) / h;
    if (i + 2 < keys.size()) {
      EXPECT_NEAR(left, right, 1e-3);
    }
  }
  EXPECT_EQ(at(keys, -1.0)[0], 1.0);
  EXPECT_EQ(at(keys, 9.0)[0], 0.0);
}

TEST(Flight, falls_by_gravity_and_passes_through_both_places) {
  const glm::dvec3 from(0, 1, 0), to(2, 0.5, -1);
  EXPECT_EQ(fly(from, 1.0, to, 1.5, 1.0), from);
  EXPECT_EQ(fly(from, 1.0, to, 1.5, 1.5), to);
  const glm::dvec3 velocity = fly_velocity(from, 1.0, to, 1.5, 1.0);
  EXPECT_LT(glm::length(throw_from(from, velocity, 0.3) - fly(from, 1.0, to, 1.5, 1.3)), 1e-12);
  EXPECT_NEAR(throw_from(from, {0, 0, 0}, 1.0).y, 1.0 - 4.905, 1e-12);
}

TEST(Flight, touches_the_ball_with_its_surface_against_the_body) {
  const glm::dvec3 center = touch(Pose{}, {0.0, 1.3, 2.0}, {0, 0, -1}, 0.11);
  EXPECT_NEAR(distance_to(pose_body(Pose{}).surface, center).distance.value, 0.11, 2e-5);
  EXPECT_NEAR(center.z, 0.22, 0.02);  // the chest
}

}  // namespace
}  // namespace pointreel::motion_test
