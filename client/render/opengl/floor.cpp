#include "client/render/opengl/floor.h"

#include <cstddef>
#include <vector>

#include "client/render/view.h"
#include "common/base/try.h"

namespace pointreel {
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
  TRY(program_.use());
  const auto bytes = static_cast<GLsizeiptr>(lines.size() * sizeof(FloorLine));
  if (lines.size() > capacity_) {
    capacity_ = lines.size();
    lines_ = gl::Buffer::create();
    glNamedBufferStorage(lines_.name(), bytes, nullptr, GL_DYNAMIC_STORAGE_BIT);
  }
  glNamedBufferSubData(lines_.name(), 0, bytes, lines.data());
  glVertexArrayVertexBuffer(array_.name(), 0, lines_.name(), 0, sizeof(FloorLine));
  glBindVertexArray(array_.name());

  const auto [light, opacity] = floor_ink(background);
  glUniform4f(0, light, light, light, opacity);
  glUniform1f(1, static_cast<float>(floor_reach(grid.bounds)));
  glUniform1i(2, grid.up.axis());
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(lines.size()));
  glDisable(GL_BLEND);
  return {};
}

}  // namespace pointreel
