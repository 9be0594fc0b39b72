#include "client/scene/camera.h"

#include <algorithm>
#include <cmath>

namespace pointreel {
namespace {

constexpr double kHighestPitch = 1.553;  // 89 degrees
constexpr double kFrontPitch = 0.15;     // "slightly from above"
constexpr double kMargin = 1.04;
constexpr double kMostCovered = 0.4;
constexpr double kNearest = 1e-3, kFarthest = 1e3;  // of the scene's radius

}  // namespace

glm::dmat3 Camera::axes() const {
  const glm::dvec3 above = up.direction();
  glm::dvec3 front = up.axis() == 2 ? glm::dvec3(0.0, -1.0, 0.0) : glm::dvec3(0.0, 0.0, 1.0);
  if (up.reversed()) front = -front;
  const glm::dvec3 beside = glm::cross(above, front);
  const glm::dvec3 right = std::cos(yaw) * beside - std::sin(yaw) * front;
  const glm::dvec3 level = std::cos(yaw) * front + std::sin(yaw) * beside;
  const glm::dvec3 back = std::cos(pitch) * level + std::sin(pitch) * above;
  return {right, glm::cross(back, right), back};
}

void Camera::aim_at(const Target& at, const Box& box) {
  if (const auto* point = std::get_if<glm::dvec3>(&at)) {
    target = *point;
  } else {
    target = box.center() + (std::get<double>(at) - 0.5) * box.extent()[up.axis()] * up.direction();
  }
}

void Camera::frame_bounds(const Box& box, double aspect) {
  yaw = 0.0;
  pitch = kFrontPitch;
  fit(box, aspect);
}

void Camera::fit(const Box& box, double aspect, double covered) {
  target = box.center();
  glm::dvec3 half = 0.5 * box.extent();
  if (!(glm::length(half) > 0.0)) half = glm::dvec3(0.5);
  scene_radius = glm::length(half);

  // The target is moved down by c t d, with the covered share c, the distance d and the tangent t
  // of half the field of view. A corner is then visible if |x| <= t aspect (d - z) and
  // -(1 - 2 c) t (d - z) <= y + c t d <= t (d - z): the least distance follows for each corner.
  const glm::dmat3 to_eye = glm::transpose(axes());
  const double t = std::tan(0.5 * fov_y), inner = t / kMargin;
  const double c = std::clamp(covered, 0.0, kMostCovered), below = (1.0 - 2.0 * c) * inner;
  distance = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 sign(corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0,
                          corner & 4 ? 1.0 : -1.0);
    const glm::dvec3 p = to_eye * (sign * half);
    distance =
        std::max({distance, p.z + std::abs(p.x) / (aspect * inner),
                  (p.y + inner * p.z) / (inner - c * t), (below * p.z - p.y) / (below + c * t)});
  }
  pan(0.0, -0.5 * c);
}

void Camera::orbit(double yaw_by, double pitch_by) {
  constexpr double kTurn = 6.283185307179586;
  yaw = std::remainder(yaw + yaw_by, kTurn);
  pitch = std::clamp(pitch + pitch_by, -kHighestPitch, kHighestPitch);
}

void Camera::pan(double right_by, double up_by) {
  const double height = 2.0 * distance * std::tan(0.5 * fov_y);
  const glm::dmat3 frame = axes();
  target += height * (right_by * frame[0] + up_by * frame[1]);
}

void Camera::zoom(double factor) {
  distance = std::clamp(distance * factor, kNearest * scene_radius, kFarthest * scene_radius);
}

void Camera::zoom_at(double factor, const glm::dvec2& cursor, double aspect) {
  const double before = distance;
  zoom(factor);
  const double t = std::tan(0.5 * fov_y);
  const glm::dmat3 frame = axes();
  target += (before - distance) * t * (cursor.x * aspect * frame[0] + cursor.y * frame[1]);
}

void Camera::center_on(const glm::dvec3& point) {
  const double depth = glm::dot(eye() - point, axes()[2]);
  if (depth > 0.0) distance = depth;
  zoom(1.0);
  target = point;
}

void Camera::fly(const glm::dvec3& move, double yaw_by, double pitch_by) {
  const glm::dvec3 from = eye();
  orbit(yaw_by, pitch_by);
  const glm::dmat3 frame = axes();
  target = from + move.x * frame[0] + move.y * up.direction() - (move.z + distance) * frame[2];
}

glm::mat4 Camera::view_from(const glm::dvec3& origin) const {
  const glm::dmat3 to_eye = glm::transpose(axes());
  glm::dmat4 view(to_eye);
  view[3] = glm::dvec4(to_eye * (origin - eye()), 1.0);
  return glm::mat4(view);
}

glm::mat4 Camera::projection(double aspect) const {
  const double f = 1.0 / std::tan(0.5 * fov_y);
  glm::mat4 p(0.0f);
  p[0][0] = static_cast<float>(f / aspect);
  p[1][1] = static_cast<float>(f);
  p[2][3] = -1.0f;
  p[3][2] = static_cast<float>(near_plane());
  return p;
}

double Camera::near_plane() const { return 1e-3 * std::min(distance, scene_radius); }

}  // namespace pointreel
