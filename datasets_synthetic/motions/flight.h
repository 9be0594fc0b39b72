#pragma once

#include <glm/glm.hpp>

#include "datasets_synthetic/body.h"

namespace pointreel {

inline constexpr double kGravity = 9.81;  // m/s^2

/// The position at `time` of an object that is thrown so that it is at `from` at `from_time` and at
/// `to` at `to_time`.
glm::dvec3 fly(const glm::dvec3& from, double from_time, const glm::dvec3& to, double to_time,
               double time);

/// The velocity of the same throw.
glm::dvec3 fly_velocity(const glm::dvec3& from, double from_time, const glm::dvec3& to,
                        double to_time, double time);

/// The position of an object `seconds` after it left `from` with `velocity`.
glm::dvec3 throw_from(const glm::dvec3& from, const glm::dvec3& velocity, double seconds);

/// The centre of a ball at the moment when it touches the posed figure (without its props), to
/// within 0.01 mm. The ball moves straight from `from` along `direction`, which has unit length.
glm::dvec3 touch(const Pose& pose, const glm::dvec3& from, const glm::dvec3& direction,
                 double ball_radius);

}  // namespace pointreel
