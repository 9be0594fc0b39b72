#include <algorithm>
#include <cmath>

#include "datasets_synthetic/motions/flight.h"
#include "datasets_synthetic/motions/motions.h"
#include "datasets_synthetic/motions/puppet.h"
#include "datasets_synthetic/motions/track.h"
#include "datasets_synthetic/vectors.h"

// Three bounces under the right hand, both hands on the ball, a deep bend, a jump, a shot at the
// top of the jump, and a soft landing.

namespace pointreel {
namespace basketball_tables {
namespace {

// A bounce: the hand releases the ball at the height kLow (metres) on its way down and meets it
// there on its way up. The durations are in seconds.
constexpr double kLow = 0.73, kDown = 0.19, kUp = 0.26, kPush = 0.20;
constexpr double kBounce = kDown + kUp + kPush;
constexpr int kBounces = 3;
constexpr double kFirstRelease = 0.10;
constexpr double kCaught = kFirstRelease + kBounces * kBounce - kPush;  // both hands take it
constexpr double kRelease = 86.0 / 30.0;
constexpr double kOutOfSight =
    2.37;  // height of the centre from which the ball is not shown, metres
constexpr glm::dvec3 kSpot{-0.32, 0.0, 0.42};

// Pelvis x, y, z; hips pitch, roll, twist; spine pitch, roll, twist. From 2.62 to 3.02 s the figure
// is 0.5 g (t - 2.62) (3.02 - t) above the ground.
constexpr Track<9, 20> kTrunk = {{
    {0.00, {-0.02, -0.15, 0.00, 10, 0, 6, 16, 2, 4}},
    {0.33, {-0.01, -0.13, 0.00, 9, 0, 4, 14, 0, 2}},
    {0.65, {-0.02, -0.15, 0.00, 10, 0, 6, 16, 2, 4}},
    {0.98, {-0.01, -0.13, 0.00, 9, 0, 4, 14, 0, 2}},
    {1.30, {-0.02, -0.15, 0.01, 10, 0, 6, 16, 2, 4}},
    {1.63, {-0.01, -0.13, 0.02, 10, 0, 5, 14, 0, 2}},
    {1.90, {-0.01, -0.16, 0.02, 12, 0, 6, 14, 0, 0}},
    {2.10, {0.00, -0.22, 0.00, 16, 0, 6, 12, 0, 2}},
    {2.34, {0.00, -0.26, 0.00, 17, 0, 6, 10, 0, 4}},
    {2.50, {0.00, -0.12, 0.03, 10, 0, 6, 4, 0, 6}},
    {2.62, {0.00, 0.04, 0.05, 2, 0, 6, 0, 0, 8}},
    {2.67, {0.00, 0.126, 0.06, 1, 0, 6, -2, 0, 9}},
    {2.72, {0.00, 0.187, 0.07, 0, 0, 6, -3, 0, 10}},
    {2.82, {0.00, 0.236, 0.08, 0, 0, 6, -3, 0, 10}},
    {2.92, {0.00, 0.187, 0.09, 0, 0, 6, 0, 0, 9}},
    {2.97, {0.00, 0.126, 0.10, 1, 0, 6, 2, 0, 8}},
    {3.02, {0.00, 0.04, 0.10, 3, 0, 6, 4, 0, 7}},
    {3.22, {0.00, -0.17, 0.09, 12, 0, 5, 10, 0, 4}},
    {3.52, {0.00, -0.07, 0.10, 6, 0, 3, 6, 0, 2}},
    {3.78, {0.00, -0.04, 0.10, 3, 0, 2, 4, 0, 2}},
}};

// The left foot; the right foot does the same 0.14 m further back. Place x, y, z; heel, yaw, hangs,
// point.
constexpr Track<7, 13> kFoot = {{
    {0.00, {0.17, 0.00, 0.10, 0, 10, 0, 0}},
    {2.44, {0.17, 0.00, 0.10, 0, 10, 0, 0}},
    {2.62, {0.17, 0.00, 0.10, 50, 10, 0, 0}},
    {2.67, {0.168, 0.086, 0.11, 56, 9, 0, 0}},
    {2.72, {0.165, 0.147, 0.12, 58, 8, 0, 0}},
    {2.82, {0.16, 0.196, 0.14, 56, 7, 0, 0}},
    {2.92, {0.16, 0.147, 0.16, 50, 7, 0, 0}},
    {2.97, {0.16, 0.086, 0.17, 44, 7, 0, 0}},
    {3.02, {0.16, 0.00, 0.18, 36, 8, 0, 0}},
    {3.10, {0.16, 0.00, 0.18, 6, 8, 0, 0}},
    {3.16, {0.16, 0.00, 0.18, 0, 8, 0, 0}},
    {3.50, {0.16, 0.00, 0.18, 0, 8, 0, 0}},
    {3.80, {0.16, 0.00, 0.18, 0, 8, 0, 0}},
}};

// The centre of the ball while both hands hold it. The last key, after the release, gives the throw
// its direction.
constexpr Track<3, 7> kCarried = {{
    {kCaught, {-0.32, 0.73, 0.42}},
    {2.02, {-0.16, 0.92, 0.42}},
    {2.30, {-0.05, 0.98, 0.42}},
    {2.52, {-0.08, 1.42, 0.40}},
    {2.70, {-0.12, 1.86, 0.32}},
    {kRelease, {-0.12, 2.20, 0.44}},
    {2.96, {-0.12, 2.46, 0.62}},
}};
constexpr glm::dvec3 kThrow{0.0, 3.2, 2.1};  // m/s

// The direction from the centre of the ball to the palm: left x, y, z; right x, y, z.
constexpr Track<6, 6> kPalms = {{
    {kCaught, {1.0, -0.1, 0.0, -0.1, 1.0, -0.25}},
    {2.02, {1.0, -0.1, -0.1, -0.9, 0.4, -0.3}},
    {2.30, {1.0, -0.1, -0.2, -0.95, 0.15, -0.3}},
    {2.52, {1.0, 0.0, -0.2, -0.85, 0.0, -0.5}},
    {2.70, {1.0, 0.0, -0.2, -0.2, -0.4, -0.9}},
    {kRelease, {1.0, 0.0, -0.2, 0.0, -0.5, -0.87}},
}};

// Wrist x, y, z; elbow. They apply while the hand holds no ball.
constexpr Track<4, 7> kLeftHand = {{
    {0.00, {0.34, -0.34, 0.24, 40}},
    {0.98, {0.33, -0.36, 0.22, 40}},
    {1.70, {0.26, -0.34, 0.28, 35}},
    {2.90, {0.14, 0.34, 0.34, 40}},
    {3.10, {0.22, 0.10, 0.40, 40}},
    {3.40, {0.26, -0.36, 0.24, 25}},
    {3.78, {0.23, -0.47, 0.10, 15}},
}};
constexpr Track<4, 7> kRightHand = {{
    {0.00, {-0.30, -0.36, 0.26, 5}},
    {2.60, {-0.16, 0.20, 0.30, 20}},
    {2.92, {-0.12, 0.48, 0.24, 20}},
    {3.06, {-0.12, 0.46, 0.28, 20}},
    {3.24, {-0.16, 0.20, 0.42, 25}},
    {3.50, {-0.25, -0.36, 0.24, 25}},
    {3.78, {-0.23, -0.47, 0.10, 15}},
}};

const double kSize = radius(Ball::Kind::basketball);

struct BallState {
  glm::dvec3 center{0.0};
  double spin = 0.0;  // radians, about x
  double held_left = 0.0, held_right = 0.0;
  glm::dvec3 left_palm{1, 0, 0}, right_palm{0, 1, 0};  // directions from the centre, unit length
  glm::dvec3 right_held{0.0};  // the ball centre that the right palm follows
};

/// The height, at the share s of `duration`, of a movement between two heights with the given
/// speeds at both ends.
double hermite(double from, double speed, double to, double to_speed, double duration, double s) {
  return from + (to - from) * s * s * (3.0 - 2.0 * s) +
         duration * speed * s * (1.0 - s) * (1.0 - s) - duration * to_speed * s * s * (1.0 - s);
}

BallState dribbled(double time) {
  const glm::dvec3 low = kSpot + glm::dvec3(0, kLow, 0), floor = kSpot + glm::dvec3(0, kSize, 0);
  const double speed_down = fly_velocity(low, 0.0, floor, kDown, 0.0).y;
  const double speed_up = fly_velocity(floor, 0.0, low, kUp, kUp).y;
  const double since = kBounce * fraction((time - kFirstRelease) / kBounce);
  BallState ball;
  ball.spin = 0.9 * time;
  ball.right_palm = unit(glm::dvec3(-0.1, 1.0, -0.25));
  if (since < kDown) {
    ball.center = fly(low, 0.0, floor, kDown, since);
  } else if (since < kDown + kUp) {
    ball.center = fly(floor, 0.0, low, kUp, since - kDown);
  } else {
    const double share = (since - kDown - kUp) / kPush;
    ball.center = low;
    ball.center.y = hermite(kLow, speed_up, kLow, speed_down, kPush, share);
  }
  // While the ball is away, the hand follows through, waits, and then moves along with the ball.
  ball.right_held = ball.center;
  if (since < kDown + kUp) {
    ball.right_held.y =
        hermite(kLow, speed_down, kLow, speed_up, kDown + kUp, since / (kDown + kUp));
    ball.right_held.y = std::max(ball.right_held.y, ball.center.y);
  }
  ball.held_right = 1.0;
  return ball;
}

BallState ball_at(double time) {
  if (time < kCaught) {
    BallState ball = dribbled(time);
    ball.held_left = rise(kCaught - 0.18, kCaught + 0.06, time);
    return ball;
  }
  const auto palms = at(kPalms, time);
  BallState ball;
  ball.spin = 0.9 * kCaught;
  ball.left_palm = unit({palms[0], palms[1], palms[2]});
  ball.right_palm = unit({palms[3], palms[4], palms[5]});
  const double carried = std::min(time, kRelease);
  ball.center = throw_from(vector_of(at(kCarried, carried)), kThrow, time - carried);
  ball.spin -= 9.0 * (time - carried);  // backspin
  ball.right_held = ball.center;
  ball.held_left = 1.0 - rise(kRelease - 0.12, kRelease + 0.04, time);
  ball.held_right = 1.0 - rise(kRelease, kRelease + 0.10, time);
  return ball;
}

}  // namespace
}  // namespace basketball_tables

Pose basketball(double seconds) {
  using namespace basketball_tables;
  const double time = std::clamp(seconds, 0.0, 113.0 / 30.0);
  const BallState ball = ball_at(time);
  Puppet puppet;
  set_trunk(puppet, at(kTrunk, time));
  puppet.feet[0] = foot_goal(at(kFoot, time));
  puppet.feet[1] = puppet.feet[0];
  puppet.feet[1].place = puppet.feet[0].place * glm::dvec3(-1, 1, 1) - glm::dvec3(0, 0, 0.14);
  puppet.feet[1].yaw = -puppet.feet[0].yaw;
  puppet.hands = {hand_goal(at(kLeftHand, time)), hand_goal(at(kRightHand, time))};
  HandGoal& left = puppet.hands[0];
  HandGoal& right = puppet.hands[1];
  left.held = ball.center + kSize * ball.left_palm;
  left.holds = ball.held_left;
  if (ball.held_left > 0.0) left.palm = -ball.left_palm;
  right.held = ball.right_held + kSize * ball.right_palm;
  right.holds = ball.held_right;
  right.palm = -ball.right_palm;
  left.curl = right.curl = 0.22;
  left.elbow += 0.25 * ball.held_left;
  right.extension = -1.2 * (rise(kRelease + 0.03, kRelease + 0.15, time) - rise(3.05, 3.35, time));
  const double up = rise(kCaught, 2.4, time);
  puppet.gaze = glm::dvec3(0.3, 1.1, 4.0) + up * glm::dvec3(-0.3, 1.9, 0.5);
  Pose pose = pose_puppet(puppet);
  if (ball.center.y < kOutOfSight && time < kRelease + 0.3) {
    pose.ball = Ball{Ball::Kind::basketball, ball.center, rotation({ball.spin, 0.2, 0.4})};
  }
  return pose;
}

}  // namespace pointreel
