#include "datasets_synthetic/motions/flight.h"
#include "datasets_synthetic/motions/motions.h"
#include "datasets_synthetic/motions/puppet.h"
#include "datasets_synthetic/motions/track.h"

// Two steps of run-up, the left foot planted beside the ball, a shot with the right instep, and a
// step to regain balance.

namespace pointreel {
namespace soccer_shoot_tables {
namespace {

constexpr double kShot = 35.0 / 30.0;  // the instep hits the ball, exactly at a pose
constexpr double kOutOfSight = 0.8;    // metres after which the ball leaves the scanned volume

// Pelvis x, y, z; hips pitch, roll, twist; spine pitch, roll, twist.
constexpr Track<9, 11> kTrunk = {{
    {0.00, {0.02, -0.03, -0.84, 6, 0, -10, 6, 0, 16}},
    {0.25, {0.05, -0.01, -0.64, 6, 2, 0, 5, -2, 0}},
    {0.45, {-0.01, -0.05, -0.44, 6, 0, 12, 5, 0, -18}},
    {0.68, {-0.03, -0.02, -0.22, 4, -2, -8, 2, 2, 8}},
    {0.90, {0.06, -0.06, 0.00, 0, -5, -30, -3, 4, 24}},
    {1.03, {0.11, -0.08, 0.06, -3, -10, -32, -1, 4, 22}},
    {1.165, {0.15, -0.07, 0.10, -6, -16, -4, 9, 7, 4}},
    {1.30, {0.16, -0.03, 0.15, -8, -14, 24, 18, 7, -24}},
    {1.48, {0.15, -0.02, 0.22, -2, -8, 34, 14, 4, -32}},
    {1.78, {0.08, -0.07, 0.40, 6, 0, 12, 8, 0, -10}},
    {2.00, {0.04, -0.04, 0.46, 4, 0, 6, 4, 0, -4}},
}};

// Wrist x, y, z; elbow.
constexpr Track<4, 9> kLeftHand = {{
    {0.00, {0.22, -0.40, 0.02, 15}},
    {0.34, {0.17, -0.27, 0.28, 15}},
    {0.72, {0.27, -0.40, -0.16, 20}},
    {1.00, {0.50, -0.16, -0.16, 30}},
    {1.12, {0.49, -0.20, 0.02, 30}},
    {1.24, {0.34, -0.26, 0.28, 30}},
    {1.40, {0.12, -0.30, 0.34, 25}},
    {1.74, {0.24, -0.44, 0.10, 20}},
    {2.00, {0.23, -0.48, 0.04, 15}},
}};
constexpr Track<4, 8> kRightHand = {{
    {0.00, {-0.18, -0.30, 0.24, 15}},
    {0.34, {-0.25, -0.40, -0.18, 15}},
    {0.72, {-0.18, -0.28, 0.27, 15}},
    {1.00, {-0.24, -0.28, 0.26, 25}},
    {1.18, {-0.36, -0.38, -0.04, 25}},
    {1.38, {-0.42, -0.30, -0.22, 25}},
    {1.74, {-0.27, -0.46, 0.02, 20}},
    {2.00, {-0.23, -0.49, 0.04, 15}},
}};

// Place x, y, z; heel, yaw, hangs, point.
constexpr Track<7, 13> kLeftFoot = {{
    {0.00, {0.10, 0.00, -0.66, 0, 4, 0, 0}},
    {0.34, {0.10, 0.00, -0.66, 0, 4, 0, 0}},
    {0.53, {0.10, 0.00, -0.66, 48, 4, 0, 10}},
    {0.62, {0.11, 0.13, -0.47, 40, 4, 0.5, 15}},
    {0.75, {0.14, 0.11, -0.06, 0, 6, 0.3, 0}},
    {0.87, {0.17, 0.00, 0.14, -16, 8, 0, 0}},
    {0.95, {0.17, 0.00, 0.14, 0, 8, 0, 0}},
    {1.22, {0.17, 0.00, 0.14, 0, 8, 0, 0}},
    {1.40, {0.17, 0.00, 0.14, 28, 8, 0, 0}},
    {1.58, {0.17, 0.00, 0.14, 24, 8, 0, 0}},
    {1.80, {0.17, 0.00, 0.14, 30, 8, 0, 0}},
    {1.92, {0.17, 0.00, 0.14, 38, 8, 0, 0}},
    {2.00, {0.17, 0.00, 0.14, 40, 8, 0, 0}},
}};
constexpr Track<7, 18> kRightFoot = {{
    {0.00, {-0.10, 0.00, -1.05, 34, -4, 0, 10}},
    {0.08, {-0.10, 0.00, -1.05, 50, -4, 0, 10}},
    {0.17, {-0.10, 0.13, -0.88, 44, -4, 0.5, 15}},
    {0.30, {-0.09, 0.10, -0.50, 0, -4, 0.3, 0}},
    {0.42, {-0.08, 0.00, -0.28, -16, -4, 0, 0}},
    {0.50, {-0.08, 0.00, -0.28, 0, -4, 0, 0}},
    {0.76, {-0.08, 0.00, -0.28, 0, -4, 0, 0}},
    {0.90, {-0.08, 0.00, -0.28, 46, -4, 0, 30}},
    {0.98, {-0.12, 0.22, -0.42, 50, -6, 0.9, 40}},
    {1.05, {-0.15, 0.32, -0.36, 50, -8, 1, 48}},
    {1.165, {-0.09, 0.115, 0.10, 40, 0, 1, 48}},
    {1.25, {-0.03, 0.26, 0.58, 30, 6, 1, 45}},
    {1.35, {0.06, 0.62, 0.80, 20, 10, 1, 40}},
    {1.45, {0.08, 0.68, 0.82, 10, 10, 1, 30}},
    {1.62, {0.00, 0.26, 0.78, 0, 4, 0.6, 5}},
    {1.76, {-0.06, 0.00, 0.64, -10, 0, 0, 0}},
    {1.84, {-0.06, 0.00, 0.64, 0, 0, 0, 0}},
    {2.00, {-0.06, 0.00, 0.64, 0, 0, 0, 0}},
}};

Puppet puppet_at(double time) {
  Puppet puppet;
  set_trunk(puppet, at(kTrunk, time));
  puppet.hands = {hand_goal(at(kLeftHand, time)), hand_goal(at(kRightHand, time))};
  puppet.feet = {foot_goal(at(kLeftFoot, time)), foot_goal(at(kRightFoot, time))};
  return puppet;
}

}  // namespace
}  // namespace soccer_shoot_tables

Pose soccer_shoot(double seconds) {
  using namespace soccer_shoot_tables;
  const double time = std::clamp(seconds, 0.0, 59.0 / 30.0);
  const double size = radius(Ball::Kind::soccer);
  const glm::dvec3 spot =
      touch(pose_puppet(puppet_at(kShot)), {-0.08, size, 1.2}, {0, 0, -1}, size);
  const glm::dvec3 velocity(0.4, 2.8, 11.0);
  const double flown = std::max(0.0, time - kShot);
  Ball ball{Ball::Kind::soccer, throw_from(spot, velocity, flown),
            rotation({0.4 - 12.0 * flown, 0.3, 0.7})};
  Puppet puppet = puppet_at(time);
  puppet.gaze = spot + rise(0.0, 0.35, flown) * glm::dvec3(0.2, 1.1, 4.0);
  Pose pose = pose_puppet(puppet);
  if (ball.center.z - spot.z < kOutOfSight) pose.ball = ball;
  return pose;
}

}  // namespace pointreel
