#include "client/render/opengl/gl_objects.h"

#include "client/render/opengl/shaders.h"
#include "common/base/try.h"

namespace pointreel::gl {
namespace {

struct ShaderKind {
  static void destroy(GLuint name) { glDeleteShader(name); }
};
using Shader = Object<ShaderKind>;

/// Drivers repeat themselves in the lines after the first.
std::string first_line(const std::string& log) {
  const std::size_t end = log.find_first_of("\n\0", 0, 2);
  return log.substr(0, end);
}

Result<Shader> compile(const Stage& stage) {
  std::string text = "#version 450 core\n";
  auto append = [&text, number = 0](std::string_view file) mutable -> Result<void> {
    const std::string_view source = shader_source(file);
    if (source.empty())
      return fail(ErrorCode::not_found, "there is no shader " + std::string(file));
    text += "#line 1 " + std::to_string(number++) + '\n';
    text += source;
    text += '\n';
    return {};
  };
  TRY(append("shaders/common.glsl"));
  for (const std::string_view file : stage.files) TRY(append(file));
  const GLchar* const pointer = text.c_str();
  Shader shader(glCreateShader(stage.type));
  glShaderSource(shader.name(), 1, &pointer, nullptr);
  glCompileShader(shader.name());
  GLint ok = GL_FALSE;
  glGetShaderiv(shader.name(), GL_COMPILE_STATUS, &ok);
  if (ok == GL_TRUE) return shader;
  std::string log(4096, '\0');
  glGetShaderInfoLog(shader.name(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  return fail(ErrorCode::unsupported, "shader " + std::string(stage.files.back()) +
                                          " does not compile: " + first_line(log));
}

}  // namespace

GLuint BufferKind::create() {
  GLuint name = 0;
  glCreateBuffers(1, &name);
  return name;
}
void BufferKind::destroy(GLuint name) { glDeleteBuffers(1, &name); }

GLuint VertexArrayKind::create() {
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  return name;
}
void VertexArrayKind::destroy(GLuint name) { glDeleteVertexArrays(1, &name); }

GLuint TextureKind::create() {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &name);
  return name;
}
void TextureKind::destroy(GLuint name) { glDeleteTextures(1, &name); }

GLuint BufferTextureKind::create() {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &name);
  return name;
}
void BufferTextureKind::destroy(GLuint name) { glDeleteTextures(1, &name); }

GLuint FramebufferKind::create() {
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  return name;
}
void FramebufferKind::destroy(GLuint name) { glDeleteFramebuffers(1, &name); }

void ProgramKind::destroy(GLuint name) { glDeleteProgram(name); }

Texture make_texture(GLenum format, int width, int height) {
  Texture texture = Texture::create();
  glTextureStorage2D(texture.name(), 1, format, width, height);
  glTextureParameteri(texture.name(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(texture.name(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

Texture view_texture(const Texture& texture, GLenum format) {
  GLuint name = 0;
  glGenTextures(1, &name);  // glTextureView needs a name that has no target yet
  Texture view(name);
  glTextureView(name, GL_TEXTURE_2D, texture.name(), format, 0, 1, 0, 1);
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTextureParameteri(name, GL_TEXTURE_SWIZZLE_A, GL_ONE);
  return view;
}

Result<Framebuffer> make_framebuffer(const Texture& color) { return make_framebuffer(color, {}); }

Result<Framebuffer> make_framebuffer(const Texture& color, const Texture& depth) {
  Framebuffer framebuffer = Framebuffer::create();
  glNamedFramebufferTexture(framebuffer.name(), GL_COLOR_ATTACHMENT0, color.name(), 0);
  // Without a depth texture the name is 0, which attaches nothing.
  glNamedFramebufferTexture(framebuffer.name(), GL_DEPTH_ATTACHMENT, depth.name(), 0);
  const GLenum status = glCheckNamedFramebufferStatus(framebuffer.name(), GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    return fail(ErrorCode::unsupported,
                "the graphics driver refuses a framebuffer, status " + std::to_string(status));
  }
  return framebuffer;
}

Result<Program> make_program(std::span<const Stage> stages) {
  Program program(glCreateProgram());
  std::string files;
  for (const Stage& stage : stages) {
    const Shader shader = TRY(compile(stage));
    glAttachShader(program.name(), shader.name());
    files += (files.empty() ? "" : " and ") + std::string(stage.files.back());
  }
  glLinkProgram(program.name());
  GLint ok = GL_FALSE;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &ok);
  if (ok == GL_TRUE) return program;
  std::string log(4096, '\0');
  glGetProgramInfoLog(program.name(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  return fail(ErrorCode::unsupported, "shaders " + files + " do not link: " + first_line(log));
}

Result<void> LateProgram::use() {
  if (program_.name() == 0) program_ = TRY(make_program(stages_));
  glUseProgram(program_.name());
  return {};
}

}  // namespace pointreel::gl
