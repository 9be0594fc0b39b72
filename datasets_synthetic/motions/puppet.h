#pragma once

#include <array>
#include <optional>

#include <glm/glm.hpp>

#include "datasets_synthetic/body.h"

namespace pointreel {

/// Where a hand goes. The elbow follows (two-bone inverse kinematics).
struct HandGoal {
  /// The wrist, in the chest's frame from the middle between the shoulders; metres. A hanging arm's
  /// is (+-0.185, -0.54, 0); the arm is 0.54 long.
  glm::dvec3 wrist{0.0};
  /// How far the elbow is turned outwards about the line from shoulder to wrist, radians. At 0 it
  /// points backwards from an arm that hangs and downwards from one that reaches forwards.
  double elbow = 0.0;
  double extension = 0.0;  ///< of the wrist, towards the back of the hand; radians
  double curl = 0.25;      ///< of the fingers: 0 straight, 1 a fist
  /// Where the palm faces (world, any length > 0), as well as the forearm's direction lets it;
  /// zero: as the elbow turns it.
  glm::dvec3 palm{0.0};
  /// Instead of `wrist`, by the share `holds` (0 to 1): where the middle of the palm goes; world.
  /// By the same share the wrist turns (on from `extension`) until the palm faces along `palm`.
  glm::dvec3 held{0.0};
  double holds = 0.0;
};

/// Where a foot goes. The knee follows, over the toes.
struct FootGoal {
  glm::dvec3 place{0.0};  ///< what is below the ankle when the foot lies flat and straight; world
  /// Radians that the heel is raised by, over the toes, which stay where they are; less than 0: the
  /// toes are, over the heel.
  double heel = 0.0;
  double yaw = 0.0;  ///< turned to the figure's left about the ball of the foot, radians
  /// The share by which the foot is not placed flat but hangs from its shin: then `place` is 9 cm
  /// below the ankle, `yaw` still turns the knee, and `point` stretches the foot, radians.
  double hangs = 0.0;
  double point = 0.0;
};

/// A pose said as an animator would say it: trunk by angles, hands and feet by place.
struct Puppet {
  glm::dvec3 pelvis{0.0};  ///< from its place in rest, metres
  Turn hips;               ///< of the pelvis
  Turn spine;              ///< of the chest against the pelvis
  Turn neck;               ///< of the head against the chest, where it does not look at `gaze`
  std::optional<glm::dvec3> gaze;  ///< world
  std::array<HandGoal, 2> hands;   ///< left, right
  std::array<FootGoal, 2> feet;
};

/// The same from rows of tables; angles in degrees. Trunk: pelvis x, y, z; hips pitch, roll, twist;
/// spine pitch, roll, twist. Hand: wrist x, y, z; elbow. Foot: place x, y, z; heel, yaw, hangs,
/// point.
void set_trunk(Puppet& puppet, const std::array<double, 9>& row);
HandGoal hand_goal(const std::array<double, 4>& row);
FootGoal foot_goal(const std::array<double, 7>& row);

Pose pose_puppet(const Puppet& puppet);

/// The frame that everything in the chest's frame is meant in: its joint is the middle between the
/// shoulders. Hands and feet of the puppet do not matter.
Frame chest_frame(const Puppet& puppet);

}  // namespace pointreel
