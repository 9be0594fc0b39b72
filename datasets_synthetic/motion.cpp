#include "datasets_synthetic/motion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "datasets_synthetic/motions/motions.h"
#include "datasets_synthetic/motions/track.h"
#include "datasets_synthetic/trigonometry.h"

namespace pointreel {
namespace {

constexpr double kStride = 1.0;      // seconds for two steps
constexpr double kWalkPeriod = 2.0;  // two strides, one wave

/// The angles of one leg in radians. Hip and ankle turn forwards and up, the knee turns backwards.
struct Leg {
  double hip, knee, foot, toes;  // `foot` is relative to the ground, positive with the toes up
};

/// `cycle`, 0 to 1, is the share of the stride since the heel touched the ground; the foot leaves
/// the ground at about 0.62. The curves have the shape that textbooks on gait analysis show (hip
/// +30 to -15 degrees, knee 5 to 60, heel rising before push-off).
Leg leg_at(double cycle) {
  Leg leg;
  leg.hip = 0.13 + 0.38 * cosine(2.0 * kPi * cycle);
  const double swing = std::max(0.0, sine(2.0 * kPi * (0.96 - cycle)));
  const double yield = rise(0.0, 0.12, cycle) - rise(0.12, 0.35, cycle);
  leg.knee = 0.08 + 0.95 * swing * swing + 0.18 * yield;
  leg.foot = 0.28 * (1.0 - rise(0.0, 0.1, cycle)) - 0.75 * rise(0.4, 0.62, cycle) +
             0.75 * rise(0.64, 0.85, cycle) + 0.28 * rise(0.8, 1.0, cycle);
  leg.toes = 0.5 * (rise(0.4, 0.6, cycle) - rise(0.6, 0.72, cycle));
  return leg;
}

}  // namespace

Pose walk(double seconds) {
  const double cycle = fraction(seconds / kStride);  // of the left leg
  const double phase = 2.0 * kPi * cycle;
  const double forward = cosine(phase);  // 1 when the left leg is in front
  Pose pose;

  pose.offset.x = 0.018 * sine(phase);  // the weight is over the standing leg
  const Turn pelvis{0.03, -0.03 * sine(phase), -0.09 * forward};
  pose[Bone::pelvis] = rotation(pelvis);
  pose[Bone::abdomen] = rotation({0.02, 0.02 * sine(phase), 0.06 * forward});
  pose[Bone::chest] = rotation({0.01, 0.01 * sine(phase), 0.13 * forward});
  pose[Bone::neck] = rotation({-0.02, 0.0, -0.05 * forward});
  pose[Bone::head] = rotation({-0.02 + 0.015 * cosine(2.0 * phase), 0.0, -0.05 * forward});

  const auto place_leg = [&](Bone thigh, Bone shin, Bone foot, Bone toes, const Leg& leg) {
    pose[thigh] = rotation({-leg.hip - pelvis.pitch, -pelvis.roll, 0.0});
    pose[shin] = rotation({leg.knee, 0.0, 0.0});
    pose[foot] = rotation({-leg.foot + leg.hip - leg.knee, 0.0, 0.0});
    pose[toes] = rotation({-leg.toes, 0.0, 0.0});
  };
  place_leg(Bone::left_thigh, Bone::left_shin, Bone::left_foot, Bone::left_toes, leg_at(cycle));
  place_leg(Bone::right_thigh, Bone::right_shin, Bone::right_foot, Bone::right_toes,
            leg_at(fraction(cycle + 0.5)));

  // Each arm swings with the leg of the other side.
  pose[Bone::right_upper_arm] = rotation({-0.38 * forward + 0.02, -0.13, 0.0});
  pose[Bone::right_forearm] = rotation({-0.35 - 0.18 * forward, 0.0, 0.0});
  pose[Bone::right_hand] = rotation({0.0, 0.05, 0.0});

  const double time = kWalkPeriod * fraction(seconds / kWalkPeriod);
  const double wave = rise(0.2, 0.75, time) - rise(1.35, 1.9, time);
  const auto mix = [wave](double swinging, double waving) {
    return swinging + (waving - swinging) * wave;
  };
  const double shake = sine(2.0 * kPi * 3.0 * (time - 0.5));
  pose[Bone::left_upper_arm] = rotation({mix(0.38 * forward + 0.02, -0.25), mix(0.13, 1.35), 0.0});
  pose[Bone::left_forearm] = rotation(
      {mix(-0.35 + 0.18 * forward, -0.1), mix(0.0, 1.35 + 0.3 * shake), mix(0.0, -0.5 * kPi)});
  pose[Bone::left_hand] = rotation({0.0, mix(-0.05, 0.0), 0.0});
  stand_on_floor(pose);
  return pose;
}

std::span<const Motion> motions() {
  static constexpr std::array<Motion, 6> all = {{
      {"baseball", "waits for the ball and bats it away", 115, false, &baseball},
      {"basketball", "dribbles, jumps and shoots", 114, false, &basketball},
      {"kick", "a front kick, a roundhouse kick and a side kick", 150, true, &kick},
      {"soccer-juggle", "keeps the ball up with feet and thighs", 116, true, &soccer_juggle},
      {"soccer-shoot", "runs up to the ball and shoots it away", 60, false, &soccer_shoot},
      {"walk", "walks on the spot and waves its left hand", 60, true, &walk},
  }};
  return all;
}

const Motion* find_motion(std::string_view name) {
  for (const Motion& motion : motions()) {
    if (motion.name == name) return &motion;
  }
  return nullptr;
}

}  // namespace pointreel
