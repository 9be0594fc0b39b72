#include <cstddef>

#include "datasets_synthetic/motions/flight.h"
#include "datasets_synthetic/motions/motions.h"
#include "datasets_synthetic/motions/puppet.h"
#include "datasets_synthetic/motions/track.h"
#include "datasets_synthetic/trigonometry.h"

// Six touches, alternating between right and left: foot, foot, thigh, foot, foot, thigh. Between
// the touches the ball flies freely.

namespace pointreel {
namespace soccer_juggle_tables {
namespace {

constexpr double kPeriod = 116.0 / 30.0;
constexpr std::size_t kTouches = 6;
constexpr double kBetween = kPeriod / kTouches;
constexpr double kFirst = 0.5 * kBetween;  // the time when the right foot touches the ball

enum class Part { foot, thigh };
constexpr std::array<Part, kTouches> kParts = {Part::foot, Part::foot, Part::thigh,
                                               Part::foot, Part::foot, Part::thigh};

// The left foot around its touch at time 0. Place x, y, z; heel, yaw, hangs, point.
constexpr Track<7, 8> kFootTouch = {{
    {-0.40, {0.105, 0.00, 0.00, 0, 8, 0, 0}},
    {-0.28, {0.105, 0.00, 0.00, 28, 8, 0, 20}},
    {-0.14, {0.105, 0.10, 0.18, 8, 6, 0, 10}},
    {0.00, {0.085, 0.225, 0.52, -10, 2, 0, 0}},
    {0.07, {0.085, 0.26, 0.525, -11, 2, 0, 0}},
    {0.22, {0.10, 0.11, 0.22, 0, 6, 0, 10}},
    {0.34, {0.105, 0.00, 0.00, 8, 8, 0, 0}},
    {0.40, {0.105, 0.00, 0.00, 0, 8, 0, 0}},
}};
constexpr Track<7, 8> kThighTouch = {{
    {-0.42, {0.105, 0.00, 0.00, 0, 8, 0, 0}},
    {-0.30, {0.105, 0.00, 0.00, 34, 8, 0, 20}},
    {-0.14, {0.105, 0.22, 0.12, 30, 6, 0.9, 35}},
    {0.00, {0.09, 0.43, 0.29, 25, 2, 1, 35}},
    {0.07, {0.09, 0.475, 0.30, 25, 2, 1, 30}},
    {0.24, {0.10, 0.18, 0.13, 15, 6, 0.7, 25}},
    {0.37, {0.105, 0.00, 0.00, 10, 8, 0, 10}},
    {0.42, {0.105, 0.00, 0.00, 0, 8, 0, 0}},
}};

/// The number of the last touch before `time`, counted through all periods, and the seconds since
/// then.
struct Last {
  int touch;
  double ago;
};
Last last_touch(double time) {
  const double number = std::floor((time - kFirst) / kBetween);
  return {static_cast<int>(number), time - kFirst - number * kBetween};
}

Part part_of(int touch) {
  const int count = static_cast<int>(kTouches);
  return kParts[static_cast<std::size_t>((touch % count + count) % count)];
}

bool by_right(int touch) { return touch % 2 == 0; }

FootGoal foot_at(double time, bool right) {
  const Last last = last_touch(time);
  // Either the last touch or the next one is by this foot.
  const bool was_last = by_right(last.touch) == right;
  const Part part = part_of(was_last ? last.touch : last.touch + 1);
  const double after = was_last ? last.ago : last.ago - kBetween;
  FootGoal goal = foot_goal(part == Part::foot ? at(kFootTouch, after) : at(kThighTouch, after));
  if (right) {
    goal.place.x = -goal.place.x;
    goal.yaw = -goal.yaw;
  }
  return goal;
}

Puppet puppet_at(double time) {
  // 1 when the right leg touches the ball, -1 when the left leg does.
  const double swing = cosine(kPi * (time - kFirst) / kBetween);
  const double bob = cosine(2.0 * kPi * (time - kFirst) / kBetween);
  const double turn = sine(2.0 * kPi * time / kPeriod);
  Puppet puppet;
  puppet.pelvis = {0.06 * swing, -0.055 + 0.012 * bob, -0.02 * bob};
  puppet.hips = {-0.02 - 0.04 * bob, -0.05 * swing, 0.14 * swing};
  puppet.spine = {0.17 + 0.05 * bob, 0.13 * swing, -0.26 * swing};
  puppet.feet = {foot_at(time, false), foot_at(time, true)};
  for (std::size_t side = 0; side < 2; ++side) {
    const double s = side == 0 ? 1.0 : -1.0;  // each arm moves against the leg on its side
    HandGoal& hand = puppet.hands[side];
    hand.wrist = {s * (0.38 + 0.03 * bob + 0.02 * turn), -0.33 + 0.05 * bob - 0.04 * s * swing,
                  0.14 + 0.12 * s * swing};
    hand.elbow = 0.45 + 0.15 * s * swing;
    hand.curl = 0.2;
  }
  return puppet;
}

/// The centre of the ball at the given touch.
glm::dvec3 touched(int touch_number) {
  const double size = radius(Ball::Kind::soccer);
  const Pose pose = pose_puppet(puppet_at(kFirst + touch_number * kBetween));
  const bool foot = part_of(touch_number) == Part::foot;
  const bool right = by_right(touch_number);
  const Bone bone = foot ? (right ? Bone::right_foot : Bone::left_foot)
                         : (right ? Bone::right_thigh : Bone::left_thigh);
  const double x = right ? -0.088 : 0.088;
  const glm::dvec3 rest = foot ? glm::dvec3(x, 0.06, 0.11) : glm::dvec3(x, 0.555, 0.06);
  const Frame frame = skeleton(pose)[static_cast<std::size_t>(bone)];
  return touch(pose, frame.place(rest) + glm::dvec3(0, 0.3, 0), {0, -1, 0}, size);
}

}  // namespace
}  // namespace soccer_juggle_tables

Pose soccer_juggle(double seconds) {
  using namespace soccer_juggle_tables;
  const double time = kPeriod * fraction(seconds / kPeriod);
  const Last last = last_touch(time);
  const glm::dvec3 center =
      fly(touched(last.touch), 0.0, touched(last.touch + 1), kBetween, last.ago);
  Puppet puppet = puppet_at(time);
  puppet.gaze = center;
  Pose pose = pose_puppet(puppet);
  pose.ball = Ball{Ball::Kind::soccer, center,
                   rotation({-4.0 * kPi * time / kPeriod, 0.3, 2.0 * kPi * time / kPeriod})};
  return pose;
}

}  // namespace pointreel
