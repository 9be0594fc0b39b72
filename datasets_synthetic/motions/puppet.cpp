#include "datasets_synthetic/motions/puppet.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "datasets_synthetic/trigonometry.h"
#include "datasets_synthetic/vectors.h"

namespace pointreel {
namespace {

constexpr glm::dvec3 kMidShoulders{0.0, 1.405, -0.01};
constexpr double kDegree = kPi / 180.0;
constexpr double kLongest = 0.9995;  // share of a limb's length: a knee is never quite straight

double side_of(std::size_t side) { return side == 0 ? 1.0 : -1.0; }

Frame frame_of(const Skeleton& frames, Bone bone) { return frames[static_cast<std::size_t>(bone)]; }

/// The smallest rotation that turns (0, -1, 0) to the unit vector d.
glm::dmat3 from_down(const glm::dvec3& d) {
  const glm::dvec3 axis = glm::cross(glm::dvec3(0, -1, 0), d);  // its length is the sine
  const double c = -d.y, k = 1.0 / std::max(1.0 + c, 1e-6);
  const glm::dmat3 cross(0, axis.z, -axis.y, -axis.z, 0, axis.x, axis.y, -axis.x, 0);
  return glm::dmat3(c) + cross + k * glm::outerProduct(axis, axis);
}

/// The vector v, rotated about the unit vector `axis`.
glm::dvec3 turned(const glm::dvec3& v, const glm::dvec3& axis, double angle) {
  const double c = cosine(angle);
  return c * v + sine(angle) * glm::cross(axis, v) + (1.0 - c) * glm::dot(axis, v) * axis;
}

/// The rotation nearest to the weighted mean of two rotations that are less than half a turn apart.
glm::dmat3 mix_rotations(const glm::dmat3& a, const glm::dmat3& b, double share) {
  const glm::dmat3 mixed = (1.0 - share) * a + share * b;
  const glm::dvec3 z = unit(mixed[2]);
  const glm::dvec3 y = unit(mixed[1] - glm::dot(mixed[1], z) * z);
  return {glm::cross(y, z), y, z};
}

/// The two bones of a limb, in the frame that the limb is attached to.
struct Limb {
  glm::dvec3 upper, lower;  // directions of the bones, unit length
  glm::dvec3 hinge;         // the axis of the middle joint
};

/// A limb that reaches from its upper joint to `target`; the middle joint bends towards `pole`.
Limb bend(const glm::dvec3& target, const glm::dvec3& pole, double upper, double lower) {
  const double asked = std::sqrt(glm::dot(target, target));
  const glm::dvec3 d = target / asked;
  const double length =
      std::clamp(asked, 1.1 * std::abs(upper - lower) + 0.12, kLongest * (upper + lower));
  const glm::dvec3 across = unit(pole - glm::dot(pole, d) * d);
  const double c = (upper * upper + length * length - lower * lower) / (2.0 * upper * length);
  Limb limb;
  limb.upper = c * d + std::sqrt(std::max(0.0, 1.0 - c * c)) * across;
  limb.lower = unit(length * d - upper * limb.upper);
  limb.hinge = glm::cross(d, across);
  return limb;
}

/// The lengths of the bones of arms and legs.
struct Lengths {
  double upper_arm, forearm, thigh;
  glm::dvec3 shin;  // from knee to ankle
};
Lengths lengths(const Skeleton& rest) {
  const auto joint = [&](Bone bone) { return frame_of(rest, bone).rest_joint; };
  return {joint(Bone::left_upper_arm).y - joint(Bone::left_forearm).y,
          joint(Bone::left_forearm).y - joint(Bone::left_hand).y,
          joint(Bone::left_thigh).y - joint(Bone::left_shin).y,
          joint(Bone::left_foot) - joint(Bone::left_shin)};
}

void place_trunk(const Puppet& puppet, Pose& pose) {
  const auto part = [](const Turn& turn, double share) {
    return rotation({share * turn.pitch, share * turn.roll, share * turn.twist});
  };
  pose.offset = puppet.pelvis;
  pose[Bone::pelvis] = rotation(puppet.hips);
  pose[Bone::abdomen] = part(puppet.spine, 0.45);
  pose[Bone::chest] = part(puppet.spine, 0.55);
  pose[Bone::neck] = part(puppet.neck, 0.4);
  pose[Bone::head] = part(puppet.neck, 0.6);
  if (!puppet.gaze) return;
  const Skeleton frames = skeleton(pose);
  const glm::dmat3 chest = frame_of(frames, Bone::chest).axes;
  const glm::dvec3 eyes = frame_of(frames, Bone::head).joint + chest * glm::dvec3(0, 0.11, 0.05);
  glm::dvec3 z = unit(*puppet.gaze - eyes) * chest;  // in the chest's frame
  // A neck does not turn further: the direction keeps pointing well to the front of the chest.
  z = unit(glm::dvec3(z.x, z.y, std::max(z.z, 0.25)));
  const glm::dvec3 up = unit(glm::dvec3(0, 1, 0) - z.y * z);
  const glm::dmat3 look(glm::cross(up, z), up, z);
  const glm::dmat3 half = mix_rotations(glm::dmat3(1.0), look, 0.4);
  pose[Bone::neck] = half;
  pose[Bone::head] = glm::transpose(half) * mix_rotations(glm::dmat3(1.0), look, 0.75);
}

void place_arm(const HandGoal& goal, std::size_t side, const Skeleton& frames,
               const Lengths& length, Pose& pose) {
  const Bone upper = side == 0 ? Bone::left_upper_arm : Bone::right_upper_arm;
  const Bone fore = side == 0 ? Bone::left_forearm : Bone::right_forearm;
  const Bone hand = side == 0 ? Bone::left_hand : Bone::right_hand;
  const Frame& chest = frame_of(frames, Bone::chest);
  const glm::dvec3 shoulder = frame_of(frames, upper).rest_joint;
  const glm::dvec3 wanted = kMidShoulders + goal.wrist - shoulder;
  const glm::dvec3 held = chest.rest_joint + (goal.held - chest.joint) * chest.axes - shoulder;
  const glm::dvec3 palm_rest = glm::dvec3(-side_of(side) * 0.018, -0.06, 0.0);
  const glm::dmat3 asked_turn = rotation({0.0, side_of(side) * goal.extension, 0.0});
  glm::dmat3 hand_turn = asked_turn;
  glm::dmat3 upper_axes, fore_axes;
  glm::dvec3 to_palm(0.0);  // from the wrist
  // The palm depends on the elbow, and the elbow on the wrist, which must bring the palm to its
  // goal.
  for (int step = 0; step < (goal.holds > 0.0 ? 8 : 1); ++step) {
    const glm::dvec3 target = wanted + goal.holds * (held - to_palm - wanted);
    const glm::dvec3 d = unit(target);
    const glm::dvec3 pole =
        turned(from_down(d) * glm::dvec3(0, 0, -1), d, side_of(side) * goal.elbow);
    const Limb arm = bend(target, pole, length.upper_arm, length.forearm);
    upper_axes = glm::dmat3(arm.hinge, -arm.upper, glm::cross(arm.hinge, -arm.upper));
    glm::dvec3 x = arm.hinge;
    if (glm::dot(goal.palm, goal.palm) > 0.0) {
      const glm::dvec3 palm = unit(goal.palm) * chest.axes;
      const glm::dvec3 across = palm - glm::dot(palm, arm.lower) * arm.lower;
      if (glm::dot(across, across) > 1e-6) x = -side_of(side) * unit(across);
      // The wrist gives way until the palm lies flat on what it holds.
      const double sine = goal.holds * std::clamp(glm::dot(palm, arm.lower), -0.95, 0.95);
      const double cosine = std::sqrt(1.0 - sine * sine), s = side_of(side) * sine;
      hand_turn = asked_turn * glm::dmat3(cosine, s, 0, -s, cosine, 0, 0, 0, 1);
    }
    fore_axes = glm::dmat3(x, -arm.lower, glm::cross(x, -arm.lower));
    to_palm = fore_axes * hand_turn * palm_rest;
  }
  pose[upper] = upper_axes;
  pose[fore] = glm::transpose(upper_axes) * fore_axes;
  pose[hand] = hand_turn;
  pose.curl[side] = goal.curl;
}

struct LegPlace {
  Limb limb;             // world
  glm::dmat3 flat_axes;  // of a foot that stands
};

LegPlace leg_place(const FootGoal& goal, std::size_t side, const Skeleton& frames,
                   const Lengths& length) {
  const Bone thigh = side == 0 ? Bone::left_thigh : Bone::right_thigh;
  const Bone foot = side == 0 ? Bone::left_foot : Bone::right_foot;
  const double s = side_of(side);
  const glm::dvec3 ankle = frame_of(frames, foot).rest_joint;
  // The centres of the two spheres that the sole rolls on, so that the foot stays on the floor.
  const glm::dvec3 ball(s * 0.095, 0.036, 0.12), heel(s * 0.088, 0.044, -0.045);
  const glm::dvec3& pivot = goal.heel > 0.0 ? ball : heel;
  const glm::dmat3 yaw = rotation({0.0, 0.0, goal.yaw});
  const glm::dmat3 flat_axes = yaw * rotation({goal.heel, 0.0, 0.0});
  const glm::dvec3 base(ankle.x, 0.0, ankle.z);
  const glm::dvec3 standing = ball - base + yaw * (pivot - ball) + flat_axes * (ankle - pivot);
  const glm::dvec3 hanging(0.0, ankle.y, 0.0);
  const glm::dvec3 target =
      goal.place + standing + goal.hangs * (hanging - standing) - frame_of(frames, thigh).joint;
  const glm::dvec3 pole = from_down(unit(target)) * yaw * glm::dvec3(0, 0, 1);
  return {bend(target, pole, length.thigh, std::sqrt(glm::dot(length.shin, length.shin))),
          flat_axes};
}

void place_leg(const FootGoal& goal, std::size_t side, const Skeleton& frames,
               const Lengths& length, Pose& pose) {
  const Bone thigh = side == 0 ? Bone::left_thigh : Bone::right_thigh;
  const Bone shin = side == 0 ? Bone::left_shin : Bone::right_shin;
  const Bone foot = side == 0 ? Bone::left_foot : Bone::right_foot;
  const Bone toes = side == 0 ? Bone::left_toes : Bone::right_toes;
  const LegPlace place = leg_place(goal, side, frames, length);
  const Limb& leg = place.limb;
  const glm::dvec3 x = -leg.hinge;  // a knee bends the other way than an elbow
  const glm::dmat3 thigh_axes(x, -leg.upper, glm::cross(x, -leg.upper));
  // At rest the shin leans a little; its frame is turned back by that angle.
  const glm::dvec3 lean = unit(length.shin), up = -leg.lower;
  const glm::dvec3 y = -lean.y * up + lean.z * glm::cross(x, up);
  const glm::dmat3 shin_axes(x, y, glm::cross(x, y));
  const glm::dmat3 foot_axes =
      mix_rotations(place.flat_axes, shin_axes * rotation({goal.point, 0.0, 0.0}), goal.hangs);
  const glm::dmat3& pelvis = frame_of(frames, Bone::pelvis).axes;
  pose[thigh] = glm::transpose(pelvis) * thigh_axes;
  pose[shin] = glm::transpose(thigh_axes) * shin_axes;
  pose[foot] = glm::transpose(shin_axes) * foot_axes;
  pose[toes] = rotation({-std::max(goal.heel, 0.0) * (1.0 - goal.hangs), 0.0, 0.0});
}

}  // namespace

void set_trunk(Puppet& puppet, const std::array<double, 9>& row) {
  puppet.pelvis = {row[0], row[1], row[2]};
  puppet.hips = {row[3] * kDegree, row[4] * kDegree, row[5] * kDegree};
  puppet.spine = {row[6] * kDegree, row[7] * kDegree, row[8] * kDegree};
}

HandGoal hand_goal(const std::array<double, 4>& row) {
  HandGoal goal;
  goal.wrist = {row[0], row[1], row[2]};
  goal.elbow = row[3] * kDegree;
  return goal;
}

FootGoal foot_goal(const std::array<double, 7>& row) {
  FootGoal goal;
  goal.place = {row[0], row[1], row[2]};
  goal.heel = row[3] * kDegree;
  goal.yaw = row[4] * kDegree;
  goal.hangs = row[5];
  goal.point = row[6] * kDegree;
  return goal;
}

Pose pose_puppet(const Puppet& puppet) {
  Pose pose;
  place_trunk(puppet, pose);
  const Skeleton frames = skeleton(pose);
  const Lengths length = lengths(frames);
  for (std::size_t side = 0; side < 2; ++side) {
    place_arm(puppet.hands[side], side, frames, length, pose);
    place_leg(puppet.feet[side], side, frames, length, pose);
  }
  return pose;
}

Frame chest_frame(const Puppet& puppet) {
  Pose pose;
  place_trunk(puppet, pose);
  const Frame chest = frame_of(skeleton(pose), Bone::chest);
  return {chest.axes, chest.place(kMidShoulders), glm::dvec3(0.0)};
}

}  // namespace pointreel
