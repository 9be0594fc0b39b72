#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <epoxy/gl.h>

#include "pointreel/error.h"

namespace pointreel::gl {

/// Owns an OpenGL object. The context in which it was created must be current when it is destroyed.
/// `Kind` knows how objects of its kind are created and deleted.
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

/// A texture with one level that is sampled without filtering.
Texture make_texture(GLenum format, int width, int height);

/// A view of the same texels in another format. It reads as opaque and is filtered linearly.
Texture view_texture(const Texture& texture, GLenum format);

/// A framebuffer with a colour texture, and optionally a depth texture. Fails with
/// ErrorCode::unsupported if the driver refuses them.
Result<Framebuffer> make_framebuffer(const Texture& color);
Result<Framebuffer> make_framebuffer(const Texture& color, const Texture& depth);

/// A stage of a program: embedded files (shaders.h) that are compiled as one text in their order,
/// with shaders/common.glsl before them.
struct Stage {
  GLenum type;
  std::vector<std::string_view> files;
};

/// Compiles and links a program. Fails with ErrorCode::unsupported; the message names the last file
/// of the stage and quotes the first message of the driver's compiler, which gives places as
/// "FILE:LINE". File 0 is common.glsl, file 1 the first file of the stage.
Result<Program> make_program(std::span<const Stage> stages);

/// A program that is compiled when it is first used. A picture needs only a few of the programs of
/// a renderer, and compiling each takes the driver milliseconds.
class LateProgram {
 public:
  LateProgram() = default;  ///< must not be used
  explicit LateProgram(std::vector<Stage> stages) : stages_(std::move(stages)) {}

  /// Makes the program current, and compiles it before if necessary. Fails as make_program does.
  Result<void> use();

 private:
  std::vector<Stage> stages_;
  Program program_;
};

}  // namespace pointreel::gl
