#pragma once

#include <array>
#include <optional>

#include <glm/glm.hpp>

#include "datasets_synthetic/body.h"

namespace pointreel {

/// The goal of a hand. The elbow follows from it (two-bone inverse kinematics).
struct HandGoal {
  /// The position of the wrist in metres, in the frame of the chest, relative to the middle between
  /// the shoulders. For a hanging arm it is (+-0.185, -0.54, 0); the arm is 0.54 long.
  glm::dvec3 wrist{0.0};
  /// The angle in radians by which the elbow is turned outwards about the line from shoulder to
  /// wrist. At 0 the elbow of a hanging arm points backwards, and that of an arm stretched forwards
  /// points down.
  double elbow = 0.0;
  double extension = 0.0;  ///< of the wrist, towards the back of the hand; radians
  double curl = 0.25;      ///< of the fingers: 0 straight, 1 a fist
  /// The direction (in world coordinates, any length > 0) that the palm faces as far as the
  /// direction of the forearm permits. If zero, the elbow decides.
  glm::dvec3 palm{0.0};
  /// The middle of the palm in world coordinates. `holds`, 0 to 1, blends from `wrist` to this
  /// goal, and turns the wrist by the same share, starting from `extension`, until the palm faces
  /// along `palm`.
  glm::dvec3 held{0.0};
  double holds = 0.0;
};

/// The goal of a foot. The knee follows from it and stays above the toes.
struct FootGoal {
  glm::dvec3 place{0.0};  ///< the point below the ankle of a flat and straight foot; world
  /// The angle in radians by which the heel is raised while the toes stay in place. If negative,
  /// the toes are raised while the heel stays in place.
  double heel = 0.0;
  double yaw = 0.0;  ///< rotation to the figure's left about the ball of the foot, radians
  /// From 0 to 1: the foot stands, or hangs from the shin. If it hangs, `place` is 9 cm below the
  /// ankle, `yaw` still turns the knee, and `point` stretches the foot by this angle in radians.
  double hangs = 0.0;
  double point = 0.0;
};

/// A pose in an animator's terms: angles for the trunk, positions for hands and feet.
struct Puppet {
  glm::dvec3 pelvis{0.0};  ///< offset from its place at rest, metres
  Turn hips;               ///< rotation of the pelvis
  Turn spine;              ///< rotation of the chest relative to the pelvis
  Turn neck;               ///< rotation of the head relative to the chest, if there is no `gaze`
  std::optional<glm::dvec3> gaze;  ///< the point that the figure looks at, world
  std::array<HandGoal, 2> hands;   ///< left, right
  std::array<FootGoal, 2> feet;    ///< left, right
};

/// These fill a puppet from rows of tables with angles in degrees. Trunk: pelvis x, y, z; hips
/// pitch, roll, twist; spine pitch, roll, twist. Hand: wrist x, y, z; elbow. Foot: place x, y, z;
/// heel, yaw, hangs, point.
void set_trunk(Puppet& puppet, const std::array<double, 9>& row);
HandGoal hand_goal(const std::array<double, 4>& row);
FootGoal foot_goal(const std::array<double, 7>& row);

Pose pose_puppet(const Puppet& puppet);

/// The frame of the chest, with the middle between the shoulders as its joint. It does not depend
/// on the hands and feet of the puppet.
Frame chest_frame(const Puppet& puppet);

}  // namespace pointreel
