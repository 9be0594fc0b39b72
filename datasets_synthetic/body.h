#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "datasets_synthetic/sdf.h"

namespace pointreel {

/// The bones of the figure, each after the one that it hangs from. "Left" is the figure's own left:
/// it faces +z with y up, so its left is +x. What the figure plays with hangs from no bone and has
/// frames of its own, after the bones.
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

/// How a bone is turned against its parent, in radians. In rest (all zero) the figure stands
/// straight and its arms hang. Turned first about the bone's own y axis (`twist`), then about x
/// (`pitch`), then about z (`roll`). Positive pitch takes what hangs backwards and what stands
/// forwards; positive roll takes what hangs to the figure's left; positive twist turns to its left.
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
  glm::dmat3 axes{1.0};    ///< a rotation: how the pattern lies
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

  std::array<glm::dmat3, kBoneCount> turns;  ///< rotations, each against the bone's parent
  glm::dvec3 offset{0.0};                    ///< the pelvis's, from its place in rest; metres
  std::array<double, 2> curl{0.25, 0.25};    ///< fingers, left and right: 0 straight, 1 a fist
  std::optional<Ball> ball;
  std::optional<Bat> bat;

  glm::dmat3& operator[](Bone bone) { return turns[static_cast<std::size_t>(bone)]; }
  const glm::dmat3& operator[](Bone bone) const { return turns[static_cast<std::size_t>(bone)]; }
};

/// What a primitive of the body is made of.
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

/// A bone's frame, or a prop's.
struct Frame {
  glm::dmat3 axes{1.0};        ///< rest to world
  glm::dvec3 joint{0.0};       ///< world
  glm::dvec3 rest_joint{0.0};  ///< the same joint in rest

  glm::dvec3 place(const glm::dvec3& rest) const { return joint + axes * (rest - rest_joint); }
};
using Skeleton = std::array<Frame, kFrameCount>;

/// The frames of a pose without its surface. A prop's rest joint is the origin: the ball's centre,
/// the bat's knob.
Skeleton skeleton(const Pose& pose);

/// The posed figure and what it plays with. The figure is 1.76 m tall in rest and stands on y = 0
/// then; in other poses its height is as the pose says (stand_on_floor).
struct Body {
  /// What one primitive needs to know of its bone to be coloured.
  struct Part {
    Bone bone;
    Material material;
  };

  Surface surface;
  std::vector<Part> parts;  ///< of every primitive of the surface
  Skeleton frames{};

  /// Where the point p, moved with the bone of `primitive`, would be in rest.
  glm::dvec3 in_rest(std::size_t primitive, const glm::dvec3& p) const;
};

Body pose_body(const Pose& pose);

/// Moves the figure (not the props) up or down until its lowest point lies on y = 0.
void stand_on_floor(Pose& pose);

/// Colour of the surface point p, which belongs to `primitive`; 8-bit sRGB. The two sides of the
/// shirt, the sleeves, the trousers and the shoes differ, so that a mirrored figure is noticed from
/// every side.
glm::u8vec3 color_at(const Body& body, std::size_t primitive, const glm::dvec3& p);

}  // namespace pointreel
