#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "datasets_synthetic/sdf.h"

namespace pointreel {

/// The bones of the figure; each comes after its parent. "Left" is the figure's own left: it faces
/// +z with y up, so its left is +x. The ball and the bat have no parent; their frames follow those
/// of the bones.
enum class Bone {
  pelvis,
  abdomen,
  chest,
  neck,
  head,
  left_upper_arm,
  left_forearm,
  left_hand,
  right_upper_arm,
  right_forearm,
  right_hand,
  left_thigh,
  left_shin,
  left_foot,
  left_toes,
  right_thigh,
  right_shin,
  right_foot,
  right_toes,
  ball,
  bat,
};
inline constexpr std::size_t kBoneCount = 19;
inline constexpr std::size_t kFrameCount = kBoneCount + 2;

/// The rotation of a bone relative to its parent, in radians. At rest (all zero) the figure stands
/// straight with its arms hanging. The bone turns first about its own y axis (`twist`), then about
/// x (`pitch`), then about z (`roll`). Positive pitch moves a hanging bone backwards and an upright
/// bone forwards; positive roll moves a hanging bone to the figure's left; positive twist turns to
/// the figure's left.
struct Turn {
  double pitch = 0.0;
  double roll = 0.0;
  double twist = 0.0;
};
glm::dmat3 rotation(const Turn& turn);

struct Ball {
  enum class Kind { soccer, basketball, baseball };
  Kind kind = Kind::soccer;
  glm::dvec3 center{0.0};  ///< world, metres
  glm::dmat3 axes{1.0};    ///< the rotation of its pattern
};
/// Radius in metres: soccer 0.11, basketball 0.12, baseball 0.037.
double radius(Ball::Kind kind);

/// A baseball bat of 0.84 m.
struct Bat {
  glm::dvec3 knob{0.0};  ///< the middle of its lower end; world, metres
  glm::dmat3 axes{1.0};  ///< a rotation; y runs along the bat, away from the knob
};

struct Pose {
  Pose() { turns.fill(glm::dmat3(1.0)); }

  std::array<glm::dmat3, kBoneCount> turns;  ///< rotations, each relative to the bone's parent
  glm::dvec3 offset{0.0};                    ///< of the pelvis from its place at rest; metres
  std::array<double, 2> curl{0.25, 0.25};    ///< fingers, left and right: 0 straight, 1 a fist
  std::optional<Ball> ball;
  std::optional<Bat> bat;

  glm::dmat3& operator[](Bone bone) { return turns[static_cast<std::size_t>(bone)]; }
  const glm::dmat3& operator[](Bone bone) const { return turns[static_cast<std::size_t>(bone)]; }
};

/// The material of a primitive of the body; it decides the colours.
enum class Material {
  skin,
  head,
  hair,
  shirt,
  trim,
  pelvis,
  sleeve,
  trousers,
  shoe,
  soccer_ball,
  basketball,
  baseball,
  bat,
};

/// The coordinate frame of a bone or a prop.
struct Frame {
  glm::dmat3 axes{1.0};        ///< the rotation from rest to world coordinates
  glm::dvec3 joint{0.0};       ///< in world coordinates
  glm::dvec3 rest_joint{0.0};  ///< the same joint at rest

  glm::dvec3 place(const glm::dvec3& rest) const { return joint + axes * (rest - rest_joint); }
};
using Skeleton = std::array<Frame, kFrameCount>;

/// The frames of a pose, without its surface. The rest joint of a prop (the centre of the ball, the
/// knob of the bat) is the origin.
Skeleton skeleton(const Pose& pose);

/// The posed figure with its props. At rest the figure is 1.76 m tall and stands on y = 0; in other
/// poses the offset of the pose decides how high it is (stand_on_floor).
struct Body {
  /// The bone and the material of one primitive, which decide its colours.
  struct Part {
    Bone bone;
    Material material;
  };

  Surface surface;
  std::vector<Part> parts;  ///< one for each primitive of the surface
  Skeleton frames{};

  /// The rest position of the point p, which moves with the bone of `primitive`.
  glm::dvec3 in_rest(std::size_t primitive, const glm::dvec3& p) const;
};

Body pose_body(const Pose& pose);

/// Moves the figure (not the props) up or down until its lowest point lies on y = 0.
void stand_on_floor(Pose& pose);

/// The 8-bit sRGB colour of the surface point p, which belongs to `primitive`. Shirt, sleeves,
/// trousers and shoes differ between left and right, so that a mirrored figure is noticed from
/// every side.
glm::u8vec3 color_at(const Body& body, std::size_t primitive, const glm::dvec3& p);

}  // namespace pointreel
