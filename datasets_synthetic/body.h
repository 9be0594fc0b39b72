#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "datasets_synthetic/sdf.h"

namespace pointreel {

/// The bones of the figure, each after the one that it hangs from. "Left" is the figure's own left:
/// it faces +z with y up, so its left is +x.
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
};
inline constexpr std::size_t kBoneCount = 19;

/// How a bone is turned against its parent, in radians. In rest (all zero) the figure stands
/// straight and its arms hang. Turned first about the bone's own y axis (`twist`), then about x
/// (`pitch`), then about z (`roll`). Positive pitch takes what hangs backwards and what stands
/// forwards; positive roll takes what hangs to the figure's left.
struct Turn {
  double pitch = 0.0;
  double roll = 0.0;
  double twist = 0.0;
};

struct Pose {
  std::array<Turn, kBoneCount> turns{};
  double sway = 0.0;  ///< the pelvis's offset along x, metres

  Turn& operator[](Bone bone) { return turns[static_cast<std::size_t>(bone)]; }
  const Turn& operator[](Bone bone) const { return turns[static_cast<std::size_t>(bone)]; }
};

/// What a primitive of the body is made of.
enum class Material { skin, head, hair, shirt, pelvis, sleeve, trousers, shoe };

/// The posed figure: 1.76 m tall in rest, its lowest point on y = 0.
struct Body {
  /// What one primitive needs to know of its bone to be coloured.
  struct Part {
    Bone bone;
    Material material;
  };
  struct Frame {
    glm::dmat3 axes{1.0};        ///< rest to world
    glm::dvec3 joint{0.0};       ///< world
    glm::dvec3 rest_joint{0.0};  ///< the same joint in rest
  };

  Surface surface;
  std::vector<Part> parts;  ///< of every primitive of the surface
  std::array<Frame, kBoneCount> frames;

  /// Where the point p, moved with the bone of `primitive`, would be in rest.
  glm::dvec3 in_rest(std::size_t primitive, const glm::dvec3& p) const;
};

Body pose_body(const Pose& pose);

/// Colour of the surface point p, which belongs to `primitive`; 8-bit sRGB. The two sides of the
/// shirt, the sleeves, the trousers and the shoes differ, so that a mirrored figure is noticed from
/// every side.
glm::u8vec3 color_at(const Body& body, std::size_t primitive, const glm::dvec3& p);

}  // namespace pointreel
