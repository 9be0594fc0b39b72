#include "client/render/opengl/strip_passes.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "client/render/opengl/instancing/instance_array.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

gl::LateProgram strip_program(std::string_view fragment_file) {
  return gl::LateProgram({{GL_VERTEX_SHADER,
                           {"instancing/shaders/instance.glsl", "instancing/attribute/fetch.glsl",
                            "shaders/strip.vert.glsl"}},
                          {GL_FRAGMENT_SHADER, {fragment_file}}});
}

bool is_same(const std::weak_ptr<const SceneFrame>& a, const std::weak_ptr<const SceneFrame>& b) {
  return !a.owner_before(b) && !b.owner_before(a);
}

}  // namespace

StripPasses::StripPasses()
    : color_(strip_program("shaders/strip.frag.glsl")),
      depth_(strip_program("shaders/nothing.frag.glsl")),
      vertices_(make_instance_array(0)) {}

void StripPasses::Batch::add(std::span<const StripCut::Range> ranges, std::size_t first_index,
                             GLint first_vertex) {
  for (const StripCut::Range& range : ranges) {
    counts.push_back(static_cast<GLsizei>(range.count));
    offsets.push_back(reinterpret_cast<const void*>((first_index + range.first) * sizeof(GLuint)));
    first_vertices.push_back(first_vertex);
  }
}

void StripPasses::Batch::draw() const {
  if (counts.empty()) return;
  glMultiDrawElementsBaseVertex(GL_TRIANGLE_STRIP, counts.data(), GL_UNSIGNED_INT, offsets.data(),
                                static_cast<GLsizei>(counts.size()), first_vertices.data());
}

void StripPasses::Batch::clear() {
  counts.clear();
  offsets.clear();
  first_vertices.clear();
}

Result<void> StripPasses::set(const SceneStrips& strips, bool signs_unknown) {
  signs_unknown_ = signs_unknown;
  std::vector<std::weak_ptr<const SceneFrame>> parts;
  std::vector<std::size_t> first_indices;
  std::size_t total = 0;
  for (const SceneStrips::Part& part : strips.parts()) {
    parts.push_back(part.frame);
    first_indices.push_back(total);
    if (part.strips != nullptr) total += part.strips->indices.size();
  }
  if (!std::equal(parts.begin(), parts.end(), uploaded_.begin(), uploaded_.end(), is_same)) {
    uploaded_.clear();
    indices_ = gl::Buffer::create();
    glNamedBufferStorage(indices_.name(),
                         static_cast<GLsizeiptr>(std::max<std::size_t>(total, 1) * sizeof(GLuint)),
                         nullptr, GL_DYNAMIC_STORAGE_BIT);
    if (glGetError() == GL_OUT_OF_MEMORY)
      return fail(ErrorCode::limit, "there is no memory to draw " + std::to_string(total) +
                                        " indices of triangle strips");
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const SurfelStrips* part = strips.parts()[i].strips;
      if (part == nullptr) continue;
      glNamedBufferSubData(
          indices_.name(), static_cast<GLintptr>(first_indices[i] * sizeof(GLuint)),
          static_cast<GLsizeiptr>(part->indices.size() * sizeof(GLuint)), part->indices.data());
    }
    uploaded_ = std::move(parts);
    glVertexArrayElementBuffer(vertices_.name(), indices_.name());
  }
  for (Batch* batch : {&facing_, &mixed_, &turned_away_}) batch->clear();
  for (std::size_t i = 0; i < strips.parts().size(); ++i) {
    const SceneStrips::Part& part = strips.parts()[i];
    if (part.strips == nullptr) continue;
    const auto first_vertex = static_cast<GLint>(part.first_vertex);
    facing_.add(part.cut.facing, first_indices[i], first_vertex);
    mixed_.add(part.cut.mixed, first_indices[i], first_vertex);
    turned_away_.add(part.cut.turned_away, first_indices[i], first_vertex);
  }
  const std::span<Instance> points = points_.write(strips.points().size());
  if (points.size() < strips.points().size())
    return fail(ErrorCode::limit,
                "there is no memory to draw " + std::to_string(strips.points().size()) + " points");
  std::copy(strips.points().begin(), strips.points().end(), points.begin());
  return {};
}

/// Draws ranges in which all triangles show the side that is wanted, and others in which those that
/// do not are culled.
void StripPasses::draw(const InstanceBuffer& vertices, const Batch& wanted, const Batch& some,
                       GLenum culled) const {
  bind_instance_array(vertices_, vertices);
  glEnable(GL_PRIMITIVE_RESTART_FIXED_INDEX);
  wanted.draw();
  glCullFace(culled);
  if (!signs_unknown_) glEnable(GL_CULL_FACE);
  some.draw();
  glDisable(GL_CULL_FACE);
  glDisable(GL_PRIMITIVE_RESTART_FIXED_INDEX);
}

Result<void> StripPasses::draw_fronts(const InstanceBuffer& vertices) {
  TRY(color_.use());
  draw(vertices, facing_, mixed_, GL_BACK);
  return {};
}

Result<void> StripPasses::draw_backs(const InstanceBuffer& vertices) {
  TRY(depth_.use());
  if (!signs_unknown_) draw(vertices, turned_away_, mixed_, GL_FRONT);
  return {};
}

}  // namespace pointreel
