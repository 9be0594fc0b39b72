#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <epoxy/gl.h>

#include "pointreel/error.h"

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
struct BufferTextureKind {
  static GLuint create();
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
using BufferTexture = Object<BufferTextureKind>;
using Framebuffer = Object<FramebufferKind>;
using Program = Object<ProgramKind>;

/// A texture of one level, sampled without filtering.
Texture make_texture(GLenum format, int width, int height);

/// The same texels, read as another format. Opaque, and sampled between texels.
Texture view_texture(const Texture& texture, GLenum format);

/// A framebuffer of a colour texture, or of that and a depth texture; an error where the driver
/// refuses them.
Result<Framebuffer> make_framebuffer(const Texture& color);
Result<Framebuffer> make_framebuffer(const Texture& color, const Texture& depth);

/// Tells when the commands before it are done.
class Fence {
 public:
  Fence() = default;  ///< nothing to wait for
  Fence(Fence&& other) noexcept : sync_(std::exchange(other.sync_, nullptr)) {}
  Fence& operator=(Fence&& other) noexcept {
    std::swap(sync_, other.sync_);
    return *this;
  }
  ~Fence();

  static Fence create();
  void wait() const;

 private:
  GLsync sync_ = nullptr;
};

/// A stage of a program: embedded files (shaders.h) that are compiled one after the other as one
/// text, behind shaders/common.glsl.
struct Stage {
  GLenum type;
  std::vector<std::string_view> files;
};

/// Compiles and links. The error names the stage's last file and holds the compiler's first
/// message, which numbers lines as "FILE:LINE": file 0 is common.glsl, 1 the first of the stage.
Result<Program> make_program(std::span<const Stage> stages);

/// A program that is compiled when it is first used: a picture takes but a few of those that a
/// renderer has, and each takes the driver milliseconds.
class LateProgram {
 public:
  LateProgram() = default;  ///< none
  explicit LateProgram(std::vector<Stage> stages) : stages_(std::move(stages)) {}

  /// Compiles and links it, if that is still to be done. Errors are make_program's.
  Result<GLuint> name();
  /// The same, and makes it current.
  Result<void> use();

 private:
  std::vector<Stage> stages_;
  Program program_;
};

}  // namespace pointreel::gl
