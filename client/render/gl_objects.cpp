#include "client/render/gl_objects.h"

#include <array>

#include "client/render/shaders.h"

namespace pointreel::gl {
namespace {

struct ShaderKind {
  static void destroy(GLuint name) { glDeleteShader(name); }
};
using Shader = Object<ShaderKind>;

/// One line: the rest only repeats it.
std::string first_line(const std::string& log) {
  const std::size_t end = log.find_first_of("\n\0", 0, 2);
  return log.substr(0, end);
}

Result<Shader> compile(GLenum stage, std::string_view file) {
  // String 0 is what all stages share, string 1 the file: messages number their lines so.
  constexpr std::string_view kVersion = "#version 450 core\n#line 1 0\n";
  constexpr std::string_view kFile = "\n#line 1 1\n";
  const std::string_view common = shader_source("common.glsl"), own = shader_source(file);
  if (own.empty()) return fail("there is no shader " + std::string(file));
  const std::array<std::string_view, 4> parts = {kVersion, common, kFile, own};
  std::array<const GLchar*, 4> text{};
  std::array<GLint, 4> length{};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    text[i] = parts[i].data();
    length[i] = static_cast<GLint>(parts[i].size());
  }
  Shader shader(glCreateShader(stage));
  glShaderSource(shader.name(), static_cast<GLsizei>(parts.size()), text.data(), length.data());
  glCompileShader(shader.name());
  GLint ok = GL_FALSE;
  glGetShaderiv(shader.name(), GL_COMPILE_STATUS, &ok);
  if (ok == GL_TRUE) return shader;
  std::string log(4096, '\0');
  glGetShaderInfoLog(shader.name(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  return fail("shader " + std::string(file) + " does not compile: " + first_line(log));
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

Result<Framebuffer> make_framebuffer(const Texture& color, const Texture& depth) {
  Framebuffer framebuffer = Framebuffer::create();
  glNamedFramebufferTexture(framebuffer.name(), GL_COLOR_ATTACHMENT0, color.name(), 0);
  glNamedFramebufferTexture(framebuffer.name(), GL_DEPTH_ATTACHMENT, depth.name(), 0);
  const GLenum status = glCheckNamedFramebufferStatus(framebuffer.name(), GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    return fail("the graphics driver refuses a framebuffer, status " + std::to_string(status));
  }
  return framebuffer;
}

Result<Program> make_program(std::string_view vertex_file, std::string_view fragment_file) {
  Result<Shader> vertex = compile(GL_VERTEX_SHADER, vertex_file);
  if (!vertex) return fail(vertex.error().message);
  Result<Shader> fragment = compile(GL_FRAGMENT_SHADER, fragment_file);
  if (!fragment) return fail(fragment.error().message);
  Program program(glCreateProgram());
  glAttachShader(program.name(), vertex->name());
  glAttachShader(program.name(), fragment->name());
  glLinkProgram(program.name());
  GLint ok = GL_FALSE;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &ok);
  if (ok == GL_TRUE) return program;
  std::string log(4096, '\0');
  glGetProgramInfoLog(program.name(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  return fail("shaders " + std::string(vertex_file) + " and " + std::string(fragment_file) +
              " do not link: " + first_line(log));
}

}  // namespace pointreel::gl
