#pragma once

#include <variant>

#include <glm/glm.hpp>

#include "pointreel/geometry.h"
#include "pointreel/up.h"

namespace pointreel {

/// What is in the middle of the picture: a point, or what is at a height of the scene, as a share
/// of its own height.
using Target = std::variant<glm::dvec3, double>;

/// A camera that orbits a target. World coordinates are double and in the source's units; angles
/// are radians. Eye space is OpenGL's: x right, y up, and the camera looks along -z.
///
/// The front view (yaw 0, pitch 0) looks along -z if y or x is up, and along +y if z is up; x
/// points to the right unless it is up. An axis that points down looks as if the world had been
/// turned by half a turn about the axis to the right.
struct Camera {
  glm::dvec3 target{0.0};
  double distance = 3.0;      ///< from the target to the eye, > 0
  double yaw = 0.0;           ///< moves the eye about the up axis, to the right where positive
  double pitch = 0.0;         ///< moves the eye above the target where positive, below +-pi/2
  Up up = 'y';                ///< of the world
  double fov_y = 0.7;         ///< vertical field of view
  double scene_radius = 1.0;  ///< the size of the scene, as `zoom` and `near_plane` see it

  /// Columns: the right, up and back (from the target to the eye) axes of the eye, orthonormal.
  glm::dmat3 axes() const;
  glm::dvec3 eye() const { return target + distance * axes()[2]; }

  /// Sets target, distance and scene radius so that the whole box is visible with a margin, from
  /// where the camera looks now, in a picture of the given width over height. `covered`: the share
  /// of the picture's height, at its bottom, that is to stay free. An empty box, or one without
  /// extent, is shown as a box of edge 1.
  void fit(const Box& box, double aspect, double covered = 0.0);
  /// The same after turning the camera to the front view, slightly from above.
  void frame_bounds(const Box& box, double aspect);

  /// Sets the target. `box`: the scene whose height is meant.
  void aim_at(const Target& at, const Box& box);

  /// Turns the eye about the target. Stops short of the poles.
  void orbit(double yaw_by, double pitch_by);
  /// Moves the target, and the eye with it, in the picture's plane. The unit is the height of the
  /// picture at the target's distance.
  void pan(double right_by, double up_by);
  /// Multiplies the distance; bounded to 1/1000 and 1000 times the scene's radius.
  void zoom(double factor);
  /// The same, but the eye moves along the ray through `cursor`, so that the point under the cursor
  /// stays there. The cursor is -1 to 1 across the picture, x to the right and y up; `aspect`
  /// is the picture's width over its height.
  void zoom_at(double factor, const glm::dvec2& cursor, double aspect);
  /// Makes `point` the target, and brings it to the middle of the picture by moving the eye in the
  /// picture's plane, so that it is drawn as large as before. The distance is bounded as by `zoom`,
  /// and stays as it is if the point is not in front of the eye.
  void center_on(const glm::dvec3& point);
  /// Moves the eye by `move`, in world units: x to the right, y along the world's up axis, z in the
  /// direction of view. Then turns it on the spot: the angles are added to yaw and pitch, so that
  /// positive ones turn it to the left and down. The target moves with it. Stops short of the
  /// poles.
  void fly(const glm::dvec3& move, double yaw_by, double pitch_by);

  /// The matrix from coordinates relative to `origin` to eye space. The translation is computed in
  /// double, so that a scene far from the world's zero does not jitter. `origin` must be near the
  /// scene for the coordinates and the result to fit a float.
  glm::mat4 view_from(const glm::dvec3& origin) const;

  /// The matrix from eye space to clip coordinates, with reversed depth: 1 at the near plane, 0 at
  /// infinity. With a float depth buffer this resolves distances to about 1e-7 of themselves
  /// everywhere, however far away the farthest object is.
  glm::mat4 projection(double aspect) const;

  /// Distance of the near plane, in world units: 1/1000 of the target's distance or of the scene's
  /// radius, whichever is smaller.
  double near_plane() const;

  bool operator==(const Camera&) const = default;
};

}  // namespace pointreel
