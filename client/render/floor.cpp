#include "client/render/floor.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "client/render/srgb.h"

namespace pointreel {
namespace {

/// Of the disc, in halves of the bounds' diagonal.
constexpr double kReach = 2.0;
/// At least so many lines from the middle to the rim.
constexpr double kLeastLines = 7.0;
/// No more than this: with steps of 1, 2, 5 there never are 2.5 times the least.
constexpr int kMostLines = 64;

constexpr float kFaint = 0.5f, kStrong = 1.0f;

double half_diagonal(const Box& bounds) {
  const double half = 0.5 * glm::length(bounds.extent());
  return half > 0.0 && std::isfinite(half) ? half : 0.5 * std::sqrt(3.0);
}

/// The axes along the floor.
glm::ivec2 level_axes(char up) { return up == 'z' ? glm::ivec2(0, 1) : glm::ivec2(0, 2); }
int up_axis(char up) { return up == 'z' ? 2 : 1; }

double round_step(double at_most) {
  const double ten = std::pow(10.0, std::floor(std::log10(at_most)));
  return (at_most >= 5.0 * ten ? 5.0 : at_most >= 2.0 * ten ? 2.0 : 1.0) * ten;
}

/// Cuts off what is behind the near plane; false if that is everything.
bool clip(glm::dvec3& from, glm::dvec3& to, const glm::dvec3& eye, const glm::dvec3& back,
          double near) {
  const double a = glm::dot(eye - from, back) - near, b = glm::dot(eye - to, back) - near;
  if (a < 0.0 && b < 0.0) return false;
  if (a < 0.0) from += a / (a - b) * (to - from);
  if (b < 0.0) to += b / (b - a) * (from - to);
  return true;
}

}  // namespace

double floor_reach(const Box& bounds) { return kReach * half_diagonal(bounds); }

double floor_step(const Box& bounds) { return round_step(floor_reach(bounds) / kLeastLines); }

glm::dvec3 floor_origin(const FloorGrid& grid) {
  glm::dvec3 origin = grid.bounds.center();
  if (!grid.bounds.empty()) origin[up_axis(grid.up)] = grid.bounds.min[up_axis(grid.up)];
  return origin;
}

std::vector<FloorLine> floor_lines(const FloorGrid& grid, const Camera& camera) {
  const glm::dvec3 origin = floor_origin(grid), eye = camera.eye() - origin;
  const glm::dvec3 back = camera.axes()[2];
  const double reach = floor_reach(grid.bounds), step = floor_step(grid.bounds);
  // The next power of ten: those lines are stronger.
  const double strong = std::pow(10.0, std::floor(std::log10(step) + 1e-6) + 1.0);
  const glm::ivec2 axes = level_axes(grid.up);
  std::vector<FloorLine> lines;
  for (int i = 0; i < 2; ++i) {
    const int across = axes[i], along = axes[1 - i];
    const double first = std::ceil((origin[across] - reach) / step);
    for (int n = 0; n < kMostLines; ++n) {
      const double world = (first + n) * step, at = world - origin[across];
      if (at > reach) break;
      glm::dvec3 from(0.0);
      from[across] = at;
      glm::dvec3 to = from;
      to[along] = std::sqrt(std::max(0.0, reach * reach - at * at));
      from[along] = -to[along];
      if (!clip(from, to, eye, back, camera.near_plane())) continue;
      const bool is_strong = std::abs(std::remainder(world, strong)) < 0.5 * step;
      lines.push_back({glm::vec3(from), glm::vec3(to), is_strong ? kStrong : kFaint,
                       static_cast<float>(is_strong ? strong : step)});
    }
  }
  return lines;
}

Floor::Floor()
    : program_({{GL_VERTEX_SHADER, {"shaders/floor.vert.glsl"}},
                {GL_FRAGMENT_SHADER, {"shaders/floor.frag.glsl"}}}),
      array_(gl::VertexArray::create()) {
  const GLuint name = array_.name();
  glVertexArrayBindingDivisor(name, 0, 1);
  glVertexArrayAttribFormat(name, 0, 3, GL_FLOAT, GL_FALSE, offsetof(FloorLine, from));
  glVertexArrayAttribFormat(name, 1, 3, GL_FLOAT, GL_FALSE, offsetof(FloorLine, to));
  glVertexArrayAttribFormat(name, 2, 2, GL_FLOAT, GL_FALSE, offsetof(FloorLine, strength));
  for (GLuint attribute = 0; attribute < 3; ++attribute) {
    glVertexArrayAttribBinding(name, attribute, 0);
    glEnableVertexArrayAttrib(name, attribute);
  }
}

Result<void> Floor::draw(const FloorGrid& grid, const Camera& camera, const glm::vec3& background) {
  const std::vector<FloorLine> lines = floor_lines(grid, camera);
  if (lines.empty()) return {};
  if (auto used = program_.use(); !used) return used;
  const auto bytes = static_cast<GLsizeiptr>(lines.size() * sizeof(FloorLine));
  if (lines.size() > capacity_) {
    capacity_ = 4 * kMostLines;
    lines_ = gl::Buffer::create();
    glNamedBufferStorage(lines_.name(), static_cast<GLsizeiptr>(capacity_ * sizeof(FloorLine)),
                         nullptr, GL_DYNAMIC_STORAGE_BIT);
  }
  glNamedBufferSubData(lines_.name(), 0, bytes, lines.data());
  glVertexArrayVertexBuffer(array_.name(), 0, lines_.name(), 0, sizeof(FloorLine));
  glBindVertexArray(array_.name());

  const float luminance = 0.2126f * linear_from_srgb(background.x) +
                          0.7152f * linear_from_srgb(background.y) +
                          0.0722f * linear_from_srgb(background.z);
  // In linear light a little white on black is much, a little black on white is not.
  const bool is_dark = luminance < 0.18f;
  const float light = is_dark ? 1.0f : 0.0f, opacity = is_dark ? 0.16f : 0.5f;
  glUniform4f(0, light, light, light, opacity);
  glUniform1f(1, static_cast<float>(floor_reach(grid.bounds)));
  glUniform1i(2, up_axis(grid.up));
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(lines.size()));
  glDisable(GL_BLEND);
  return {};
}

}  // namespace pointreel
