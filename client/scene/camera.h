#pragma once

#include <glm/glm.hpp>

#include "pointreel/geometry.h"

namespace pointreel {

/// A camera that orbits a target. World coordinates are double and in the source's units; angles
/// are radians. Eye space is OpenGL's: x right, y up, and the camera looks along -z.
///
/// The front view (yaw 0, pitch 0) looks along -z where y is up, and along +y where z is up; in
/// both x points to the right.
struct Camera {
  glm::dvec3 target{0.0};
  double distance = 3.0;      ///< from the target to the eye, > 0
  double yaw = 0.0;           ///< moves the eye about the up axis, to the right where positive
  double pitch = 0.0;         ///< moves the eye above the target where positive, below +-pi/2
  char up = 'y';              ///< the world's up axis, 'y' or 'z'
  double fov_y = 0.7;         ///< vertical field of view
  double scene_radius = 1.0;  ///< what `zoom` and `near_plane` take for the size of the scene

  /// Columns: the right, up and back (from the target to the eye) axes of the eye, orthonormal.
  glm::dmat3 axes() const;
  glm::dvec3 eye() const { return target + distance * axes()[2]; }

  /// Sets target, distance and scene radius, and turns the camera to the front view, slightly from
  /// above, so that the whole box is visible with a margin in a picture of the given width over
  /// height. An empty box, or one without extent, is shown as a box of edge 1.
  void frame_bounds(const Box& box, double aspect);

  /// Turns the eye about the target; stops short of the poles.
  void orbit(double yaw_by, double pitch_by);
  /// Moves the target, and the eye with it, in the picture's plane; in heights of the picture at
  /// the target's distance, x to the right and y up.
  void pan(double right_by, double up_by);
  /// Multiplies the distance; bounded to 1/1000 and 1000 times the scene's radius.
  void zoom(double factor);
  /// The same, but the eye moves along the ray through `cursor`, so that everything that is seen
  /// there stays there. The cursor is -1 to 1 across the picture, x to the right and y up; `aspect`
  /// is the picture's width over its height.
  void zoom_at(double factor, const glm::dvec2& cursor, double aspect);
  /// Makes `point` the target, and brings it to the middle of the picture by moving the eye in the
  /// picture's plane: it is drawn as large as before. The distance is bounded as by `zoom`; of a
  /// point that is not before the eye it stays.
  void center_on(const glm::dvec3& point);
  /// Moves the eye by `move`, in world units, x to the right, y along the world's up axis and z the
  /// way it looks, and turns it where it stands. The angles are added to yaw and pitch: positive
  /// ones turn it to the left and down. The target goes with it; stops short of the poles.
  void fly(const glm::dvec3& move, double yaw_by, double pitch_by);

  /// From coordinates relative to `origin` to eye space. The translation is subtracted in double,
  /// so that a scene far from the world's zero does not jitter; only with an `origin` near the
  /// scene do the coordinates and the result both fit a float.
  glm::mat4 view_from(const glm::dvec3& origin) const;

  /// From eye space to clip coordinates with reversed depth from 1 at the near plane to 0 at
  /// infinity: together with a float depth buffer, distances are told apart to about 1e-7 of
  /// themselves everywhere, however far the farthest thing is.
  glm::mat4 projection(double aspect) const;

  /// Distance of the near plane, in world units: 1/1000 of the target's distance or of the scene's
  /// radius, whichever is less.
  double near_plane() const;

  bool operator==(const Camera&) const = default;
};

}  // namespace pointreel
