#include <algorithm>
#include <cmath>

#include "datasets_synthetic/motions/flight.h"
#include "datasets_synthetic/motions/motions.h"
#include "datasets_synthetic/motions/puppet.h"
#include "datasets_synthetic/motions/track.h"
#include "datasets_synthetic/vectors.h"

// A right-handed batter: the pitcher is on its left (+x), the plate in front of it (+z). It waits,
// shifts its weight back, strides, and swings from the hips up. The bat hits the ball and follows
// through to the other shoulder.

namespace pointreel {
namespace baseball_tables {
namespace {

constexpr double kHit = 49.0 / 30.0;  // exactly at a pose
constexpr double kInSight = 1.05;     // how far from the hit the ball is shown, metres
constexpr double kSweetSpot = 0.68;   // metres from the knob

// Pelvis x, y, z; hips pitch, roll, twist; spine pitch, roll, twist.
constexpr Track<9, 13> kTrunk = {{
    {0.00, {-0.05, -0.13, 0.00, 9, 0, -5, 16, 0, -8}},
    {0.45, {-0.01, -0.12, 0.00, 9, 0, -7, 16, 0, -6}},
    {0.90, {-0.05, -0.13, 0.00, 9, 0, -8, 16, 0, -10}},
    {1.16, {-0.14, -0.12, 0.00, 8, 3, -22, 16, 0, -18}},
    {1.42, {0.00, -0.16, 0.00, 8, 0, -12, 16, 0, -28}},
    {1.52, {0.07, -0.17, 0.01, 6, 2, 26, 14, 0, -30}},
    {kHit, {0.10, -0.15, 0.02, 2, 6, 62, 12, 0, -2}},
    {1.76, {0.12, -0.13, 0.02, 0, 6, 82, 9, 0, 24}},
    {1.98, {0.13, -0.11, 0.02, -2, 4, 90, 6, 0, 36}},
    {2.36, {0.13, -0.09, 0.02, 0, 2, 86, 6, 0, 28}},
    {2.70, {0.15, -0.07, 0.01, 2, 0, 74, 7, 0, 18}},
    {3.10, {0.16, -0.06, 0.00, 3, 0, 62, 6, 0, 8}},
    {3.78, {0.15, -0.04, 0.00, 2, 0, 56, 5, 0, 4}},
}};

// Place x, y, z; heel, yaw, hangs, point.
constexpr Track<7, 9> kLeftFoot = {{
    {0.00, {0.22, 0.00, 0.00, 0, 12, 0, 0}},
    {0.96, {0.22, 0.00, 0.00, 0, 12, 0, 0}},
    {1.04, {0.22, 0.00, 0.00, 30, 12, 0, 15}},
    {1.17, {0.17, 0.16, 0.02, 10, 10, 0.7, 18}},
    {1.32, {0.32, 0.06, 0.02, 5, 22, 0.3, 10}},
    {1.42, {0.40, 0.00, 0.02, 0, 34, 0, 0}},
    {1.56, {0.40, 0.00, 0.02, 0, 36, 0, 0}},
    {1.90, {0.40, 0.00, 0.02, 0, 60, 0, 0}},
    {3.78, {0.40, 0.00, 0.02, 0, 60, 0, 0}},
}};
constexpr Track<7, 10> kRightFoot = {{
    {0.00, {-0.26, 0.00, -0.02, 0, -6, 0, 0}},
    {1.40, {-0.26, 0.00, -0.02, 0, -6, 0, 0}},
    {1.52, {-0.26, 0.00, -0.02, 22, 18, 0, 0}},
    {kHit, {-0.26, 0.00, -0.02, 46, 46, 0, 0}},
    {1.96, {-0.26, 0.00, -0.02, 60, 76, 0, 0}},
    {2.40, {-0.26, 0.00, -0.02, 58, 76, 0, 0}},
    {2.54, {-0.20, 0.09, -0.04, 50, 74, 0.3, 20}},
    {2.76, {-0.02, 0.05, -0.10, 12, 66, 0.2, 10}},
    {2.88, {0.04, 0.00, -0.12, 0, 62, 0, 0}},
    {3.78, {0.04, 0.00, -0.12, 0, 62, 0, 0}},
}};

// In the frame of the chest, relative to the middle between the shoulders: the knob, and the
// direction of the bat.
constexpr Track<6, 15> kBat = {{
    {0.00, {-0.14, -0.14, 0.30, -0.38, 0.84, -0.30}},
    {0.45, {-0.13, -0.13, 0.31, -0.12, 0.95, -0.10}},
    {0.90, {-0.15, -0.13, 0.30, -0.40, 0.84, -0.34}},
    {1.16, {-0.21, -0.09, 0.26, -0.14, 0.90, -0.30}},
    {1.42, {-0.24, -0.11, 0.24, -0.46, 0.72, -0.52}},
    {1.50, {-0.17, -0.19, 0.30, -0.84, 0.30, -0.44}},
    {1.57, {-0.06, -0.25, 0.38, -1.00, -0.10, -0.02}},
    {kHit, {0.02, -0.26, 0.42, -0.80, -0.20, 0.56}},
    {1.69, {0.10, -0.18, 0.40, -0.12, -0.06, 1.00}},
    {1.76, {0.16, -0.08, 0.34, 0.64, 0.16, 0.74}},
    {1.86, {0.22, 0.00, 0.24, 0.94, 0.32, -0.12}},
    {1.98, {0.24, 0.04, 0.18, 0.62, 0.30, -0.72}},
    {2.36, {0.24, 0.02, 0.20, 0.60, 0.40, -0.68}},
    {3.00, {0.14, -0.22, 0.28, 0.50, 0.86, -0.12}},
    {3.78, {0.10, -0.32, 0.30, 0.34, 0.92, 0.12}},
}};

Puppet puppet_at(double time) {
  Puppet puppet;
  set_trunk(puppet, at(kTrunk, time));
  puppet.feet = {foot_goal(at(kLeftFoot, time)), foot_goal(at(kRightFoot, time))};
  return puppet;
}

Bat bat_at(const Puppet& puppet, double time) {
  const auto row = at(kBat, time);
  const Frame chest = chest_frame(puppet);
  const glm::dvec3 y = chest.axes * unit({row[3], row[4], row[5]});
  const glm::dvec3 x = unit(glm::cross(y, chest.axes * glm::dvec3(0.1, 0.2, -1.0)));
  return {chest.place({row[0], row[1], row[2]}), {x, y, glm::cross(x, y)}};
}

/// Puts both hands round the handle, the left one below, thumbs towards the barrel.
void hold(Puppet& puppet, const Bat& bat) {
  const Frame chest = chest_frame(puppet);
  for (std::size_t side = 0; side < 2; ++side) {
    const double s = side == 0 ? 1.0 : -1.0;
    const glm::dvec3 grip = bat.knob + (side == 0 ? 0.075 : 0.165) * bat.axes[1];
    const glm::dvec3 elbow = chest.place({s * 0.24, -0.24, 0.02});
    HandGoal& hand = puppet.hands[side];
    hand.palm = s * glm::cross(unit(grip - elbow), bat.axes[1]);
    hand.held = grip - 0.012 * unit(hand.palm);
    hand.holds = 1.0;
    hand.wrist = {s * 0.1, -0.2, 0.3};
    hand.elbow = 0.6;
    hand.curl = 1.0;
  }
}

}  // namespace
}  // namespace baseball_tables

Pose baseball(double seconds) {
  using namespace baseball_tables;
  const double time = std::clamp(seconds, 0.0, 114.0 / 30.0);
  Puppet puppet = puppet_at(time);
  const Bat bat = bat_at(puppet, time);
  hold(puppet, bat);

  const double size = radius(Ball::Kind::baseball);
  const Bat hitting = bat_at(puppet_at(kHit), kHit);
  const glm::dvec3 sweet = hitting.knob + kSweetSpot * hitting.axes[1];
  const glm::dvec3 off = unit(glm::dvec3(1, 0.2, 0) -
                              glm::dot(glm::dvec3(1, 0.2, 0), hitting.axes[1]) * hitting.axes[1]);
  const glm::dvec3 hit = sweet + (0.0315 + size) * off;
  const double since = time - kHit;
  const glm::dvec3 velocity = since < 0.0 ? glm::dvec3(-27, -2, 0) : glm::dvec3(29, 10, 6);
  const Ball ball{Ball::Kind::baseball, throw_from(hit, velocity, since),
                  rotation({0.3, 25.0 * since, 0.5})};
  const double after = rise(0.0, 0.5, since);
  puppet.gaze = glm::dvec3(4.0, 1.2, 0.8) * (1.0 - rise(-0.35, 0.0, since)) +
                hit * (rise(-0.35, 0.0, since) - after) + after * glm::dvec3(8.0, 4.0, 1.5);
  Pose pose = pose_puppet(puppet);
  pose.bat = bat;
  const glm::dvec3 flown = ball.center - hit;
  if (glm::dot(flown, flown) < kInSight * kInSight) pose.ball = ball;
  return pose;
}

}  // namespace pointreel
