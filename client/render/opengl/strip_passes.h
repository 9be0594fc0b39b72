#pragma once

#include <memory>
#include <span>
#include <vector>

#include <epoxy/gl.h>

#include "client/render/opengl/gl_objects.h"
#include "client/render/opengl/instance_buffer.h"
#include "client/render/scene_strips.h"

namespace pointreel {

/// Draws the triangle strips of a scene. Its surfels, which are the vertices, stay where the
/// instances are; the indices of a frame are uploaded once, and what the cut chose of them is drawn
/// in one call for each frame of the scene.
class StripPasses {
 public:
  StripPasses();

  /// Sets what the passes to come draw. Fails with ErrorCode::limit if there is too little memory.
  Result<void> set(const SceneStrips& strips, bool signs_unknown);

  /// Draws triangles into the bound framebuffer: the fronts with colours, or the depths of the
  /// backs. If the signs of normals are unknown, all are fronts. On return, faces are not culled.
  Result<void> draw_fronts(const InstanceBuffer& vertices);
  Result<void> draw_backs(const InstanceBuffer& vertices);
  /// The representative surfels, which are drawn as points.
  const InstanceBuffer& points() const { return points_; }

 private:
  /// The arguments of a draw call for many ranges of indices.
  struct Batch {
    std::vector<GLsizei> counts;
    std::vector<const void*> offsets;
    std::vector<GLint> first_vertices;

    void add(std::span<const StripCut::Range> ranges, std::size_t first_index, GLint first_vertex);
    void draw() const;
    void clear();
  };
  void draw(const InstanceBuffer& vertices, const Batch& wanted, const Batch& some,
            GLenum culled) const;

  gl::LateProgram color_, depth_;
  gl::VertexArray vertices_;
  gl::Buffer indices_;
  std::vector<std::weak_ptr<const SceneFrame>> uploaded_;  ///< whose indices are in indices_
  Batch facing_, mixed_, turned_away_;
  bool signs_unknown_ = false;
  InstanceBuffer points_;
};

}  // namespace pointreel
