#pragma once

#include <string>
#include <string_view>
#include <utility>

#include <epoxy/gl.h>

#include "common/base/error.h"

namespace pointreel::gl {

/// Owns the name of an OpenGL object. The context in which it was made must be current when it is
/// destroyed. Kind says how to make and to delete one.
template <class Kind>
class Object {
 public:
  Object() = default;  ///< owns nothing
  explicit Object(GLuint name) : name_(name) {}
  Object(Object&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  Object& operator=(Object&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  ~Object() {
    if (name_ != 0) Kind::destroy(name_);
  }

  static Object create() { return Object(Kind::create()); }
  GLuint name() const { return name_; }

 private:
  GLuint name_ = 0;
};

struct BufferKind {
  static GLuint create();
  static void destroy(GLuint name);
};
struct VertexArrayKind {
  static GLuint create();
  static void destroy(GLuint name);
};
struct TextureKind {
  static GLuint create();  ///< two-dimensional
  static void destroy(GLuint name);
};
struct FramebufferKind {
  static GLuint create();
  static void destroy(GLuint name);
};
struct ProgramKind {
  static void destroy(GLuint name);
};

using Buffer = Object<BufferKind>;
using VertexArray = Object<VertexArrayKind>;
using Texture = Object<TextureKind>;
using Framebuffer = Object<FramebufferKind>;
using Program = Object<ProgramKind>;

/// A texture of one level, sampled without filtering.
Texture make_texture(GLenum format, int width, int height);

/// A framebuffer of a colour and a depth texture; an error where the driver refuses them.
Result<Framebuffer> make_framebuffer(const Texture& color, const Texture& depth);

/// Compiles and links the two embedded shaders of these file names (shaders.h). The error names the
/// file and holds the compiler's first message.
Result<Program> make_program(std::string_view vertex_file, std::string_view fragment_file);

}  // namespace pointreel::gl
