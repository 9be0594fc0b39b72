#pragma once

#include <glm/glm.hpp>

#include "datasets_synthetic/body.h"

namespace pointreel {

inline constexpr double kGravity = 9.81;  // m/s^2

/// The place at `time` of what is thrown so that it is at `from` at one time and at `to` at
/// another.
glm::dvec3 fly(const glm::dvec3& from, double from_time, const glm::dvec3& to, double to_time,
               double time);

/// The velocity of the same throw.
glm::dvec3 fly_velocity(const glm::dvec3& from, double from_time, const glm::dvec3& to,
                        double to_time, double time);

/// The place of what leaves `from` with a velocity, `seconds` later.
glm::dvec3 throw_from(const glm::dvec3& from, const glm::dvec3& velocity, double seconds);

/// Where the centre of a ball that moves straight from `from` along `direction` (unit length) first
/// touches the posed figure (without props), to 0.01 mm.
glm::dvec3 touch(const Pose& pose, const glm::dvec3& from, const glm::dvec3& direction,
                 double ball_radius);

}  // namespace pointreel
