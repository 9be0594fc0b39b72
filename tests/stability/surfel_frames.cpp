#include "tests/stability/surfel_frames.h"

#include <cstddef>
#include <string>

#include "client/render/opengl/gl_context.h"
#include "client/render/opengl/gl_objects.h"
#include "client/render/opengl/shaders.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr const char* kMain = R"glsl(
layout(local_size_x = 1) in;
layout(std430, binding = 0) readonly buffer Normals { vec4 normals[]; };
layout(std430, binding = 1) writeonly buffer Tangents { vec4 tangents[]; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  vec3 u, v;
  surfel_frame(normals[i].xyz, u, v);
  tangents[2 * i] = vec4(u, 0.0);
  tangents[2 * i + 1] = vec4(v, 0.0);
}
)glsl";

Result<gl::Program> make_program() {
  std::string text = "#version 450 core\n";
  for (const char* file : {"shaders/common.glsl", "instancing/shaders/instance.glsl",
                           "instancing/shaders/surfel.glsl"})
    text += shader_source(file);
  text += kMain;
  const char* const source = text.c_str();
  gl::Program program(glCreateShaderProgramv(GL_COMPUTE_SHADER, 1, &source));
  GLint linked = GL_FALSE;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return program;
  std::string log(4096, '\0');
  glGetProgramInfoLog(program.name(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  return fail(ErrorCode::unsupported, "the shader does not compile: " + log);
}

gl::Buffer make_buffer(GLuint binding, const std::vector<glm::vec4>& values) {
  gl::Buffer buffer = gl::Buffer::create();
  glNamedBufferStorage(buffer.name(), static_cast<GLsizeiptr>(values.size() * sizeof(glm::vec4)),
                       values.data(), 0);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer.name());
  return buffer;
}

}  // namespace

Result<std::vector<SurfelFrame>> surfel_frames(std::span<const glm::vec3> normals) {
  if (normals.empty()) return std::vector<SurfelFrame>();
  const OffscreenContext context = TRY(OffscreenContext::create());
  const gl::Program program = TRY(make_program());
  std::vector<glm::vec4> inputs, outputs(2 * normals.size());
  for (const glm::vec3& normal : normals) inputs.emplace_back(normal, 0.0f);
  const gl::Buffer normal_buffer = make_buffer(0, inputs), tangents = make_buffer(1, outputs);
  glUseProgram(program.name());
  glDispatchCompute(static_cast<GLuint>(normals.size()), 1, 1);
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glGetNamedBufferSubData(tangents.name(), 0,
                          static_cast<GLsizeiptr>(outputs.size() * sizeof(glm::vec4)),
                          outputs.data());
  glUseProgram(0);
  std::vector<SurfelFrame> frames;
  for (std::size_t i = 0; i < normals.size(); ++i)
    frames.push_back({glm::vec3(outputs[2 * i]), glm::vec3(outputs[2 * i + 1])});
  return frames;
}

}  // namespace pointreel
