#include "datasets_synthetic/motions/flight.h"

#include <cmath>

namespace pointreel {

glm::dvec3 fly(const glm::dvec3& from, double from_time, const glm::dvec3& to, double to_time,
               double time) {
  const double share = (time - from_time) / (to_time - from_time);
  const double rise = 0.5 * kGravity * (time - from_time) * (to_time - time);
  return from + share * (to - from) + glm::dvec3(0, rise, 0);
}

glm::dvec3 fly_velocity(const glm::dvec3& from, double from_time, const glm::dvec3& to,
                        double to_time, double time) {
  const double rise = 0.5 * kGravity * (from_time + to_time - 2.0 * time);
  return (to - from) / (to_time - from_time) + glm::dvec3(0, rise, 0);
}

glm::dvec3 throw_from(const glm::dvec3& from, const glm::dvec3& velocity, double seconds) {
  return from + seconds * velocity - glm::dvec3(0, 0.5 * kGravity * seconds * seconds, 0);
}

// Sphere tracing: the distance from the body never changes faster than the position.
glm::dvec3 touch(const Pose& pose, const glm::dvec3& from, const glm::dvec3& direction,
                 double ball_radius) {
  constexpr double kTolerance = 1e-5, kFurthest = 3.0;
  Pose alone = pose;
  alone.ball.reset();
  alone.bat.reset();
  const Body body = pose_body(alone);
  double way = 0.0;
  for (int step = 0; step < 200 && way < kFurthest; ++step) {
    const glm::dvec3 center = from + way * direction;
    const double gap = distance_to(body.surface, center).distance.value - ball_radius;
    if (gap < kTolerance) break;
    way += gap;
  }
  return from + way * direction;
}

}  // namespace pointreel
