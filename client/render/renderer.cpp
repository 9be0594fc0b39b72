#include "client/render/renderer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "client/render/gl_context.h"

namespace pointreel {
namespace {

/// Towards the light, in eye space: over the viewer's left shoulder.
const glm::dvec3 kLight = glm::normalize(glm::dvec3(-0.35, 0.45, 1.0));

/// By what the visibility pass pushes a splat back, in its enlarged radii: neighbours on the same
/// surface then pass the depth test (ERRATA 9).
constexpr float kDepthTolerance = 1.0f;

constexpr GLuint kInstanceBinding = 0;

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

/// A vertex array that reads an Instance for every instance (divisor 1) or every vertex (0).
gl::VertexArray make_vertex_array(const gl::Buffer& instances, GLuint divisor) {
  gl::VertexArray array = gl::VertexArray::create();
  const GLuint name = array.name();
  glVertexArrayVertexBuffer(name, kInstanceBinding, instances.name(), 0, sizeof(Instance));
  glVertexArrayBindingDivisor(name, kInstanceBinding, divisor);
  glVertexArrayAttribFormat(name, 0, 4, GL_FLOAT, GL_FALSE, offsetof(Instance, center));
  glVertexArrayAttribFormat(name, 1, 3, GL_SHORT, GL_TRUE, offsetof(Instance, normal));
  glVertexArrayAttribFormat(name, 2, 3, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Instance, color));
  for (GLuint attribute = 0; attribute < 3; ++attribute) {
    glVertexArrayAttribBinding(name, attribute, kInstanceBinding);
    glEnableVertexArrayAttrib(name, attribute);
  }
  return array;
}

float linear_from_srgb(float c) {
  return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
}

}  // namespace

Result<Renderer> Renderer::create() {
  if (epoxy_gl_version() < 45 || !epoxy_is_desktop_gl()) {
    return fail("OpenGL 4.5 is needed to draw, but this context is " + describe_opengl());
  }
  struct Wanted {
    gl::Program Renderer::* program;
    const char* vertex;
    const char* fragment;
  };
  constexpr std::array<Wanted, 5> kPrograms = {{
      {&Renderer::visibility_, "surfel.vert.glsl", "visibility.frag.glsl"},
      {&Renderer::splat_, "surfel.vert.glsl", "splat.frag.glsl"},
      {&Renderer::resolve_, "resolve.vert.glsl", "resolve.frag.glsl"},
      {&Renderer::voxel_, "voxel.vert.glsl", "flat.frag.glsl"},
      {&Renderer::point_, "point.vert.glsl", "flat.frag.glsl"},
  }};
  Renderer renderer;
  for (const Wanted& wanted : kPrograms) {
    Result<gl::Program> program = gl::make_program(wanted.vertex, wanted.fragment);
    if (!program) return fail(program.error().message);
    renderer.*wanted.program = std::move(*program);
  }
  renderer.instance_buffer_ = gl::Buffer::create();
  renderer.view_buffer_ = gl::Buffer::create();
  glNamedBufferStorage(renderer.view_buffer_.name(), sizeof(ViewBlock), nullptr,
                       GL_DYNAMIC_STORAGE_BIT);
  renderer.per_instance_ = make_vertex_array(renderer.instance_buffer_, 1);
  renderer.per_vertex_ = make_vertex_array(renderer.instance_buffer_, 0);
  return renderer;
}

Result<void> Renderer::resize(glm::ivec2 size) {
  if (size == size_) return {};
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (size.x < 1 || size.y < 1 || size.x > largest || size.y > largest) {
    return fail("a picture of " + std::to_string(size.x) + "x" + std::to_string(size.y) +
                " pixels cannot be drawn: 1 to " + std::to_string(largest) + " each way");
  }
  gl::Texture color = gl::make_texture(GL_SRGB8_ALPHA8, size.x, size.y);
  gl::Texture sums = gl::make_texture(GL_RGBA32F, size.x, size.y);
  gl::Texture depth = gl::make_texture(GL_DEPTH_COMPONENT32F, size.x, size.y);
  Result<gl::Framebuffer> picture = gl::make_framebuffer(color, depth);
  if (!picture) return fail(picture.error().message);
  Result<gl::Framebuffer> splats = gl::make_framebuffer(sums, depth);
  if (!splats) return fail(splats.error().message);
  picture_ = std::move(*picture);
  splats_ = std::move(*splats);
  color_ = std::move(color);
  sums_ = std::move(sums);
  depth_ = std::move(depth);
  size_ = size;
  return {};
}

void Renderer::update_instances(std::shared_ptr<const SceneFrame> frame, const Camera& camera,
                                const DrawOptions& options, DrawStats& stats) {
  const bool same = frame == frame_ && options.mode == mode_;
  frame_ = std::move(frame);
  mode_ = options.mode;
  if (mode_ == DrawMode::voxel) {
    const CutKey key{camera, size_, options.pixel_size};
    if (same && cut_key_ == key) return;
    cut_key_ = key;
    const auto start = std::chrono::steady_clock::now();
    visited_ = 0;
    if (frame_) visited_ = cut_.run(frame_->svo, camera, size_, options.pixel_size).visited;
    stats.cut_ms = milliseconds_since(start);
  } else if (same) {
    return;
  }
  instances_.items.clear();
  if (frame_ && mode_ == DrawMode::voxel) {
    pack_voxels(*frame_, cut_.nodes(), instances_);
  } else if (frame_) {
    pack_points(*frame_, instances_);
  }
  // A new store each time: the driver need not wait until the last picture has read the old one.
  glNamedBufferData(instance_buffer_.name(),
                    static_cast<GLsizeiptr>(instances_.items.size() * sizeof(Instance)),
                    instances_.items.data(), GL_STREAM_DRAW);
}

Result<DrawStats> Renderer::draw(std::shared_ptr<const SceneFrame> frame, const Camera& camera,
                                 glm::ivec2 size, const DrawOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  if (Result<void> resized = resize(size); !resized) return fail(resized.error().message);
  DrawStats stats;
  update_instances(std::move(frame), camera, options, stats);
  stats.drawn = static_cast<std::uint32_t>(instances_.items.size());
  stats.visited = mode_ == DrawMode::voxel ? visited_ : 0;

  const glm::dvec3 origin = instances_.origin;
  const ViewBlock view{
      camera.projection(static_cast<double>(size.x) / size.y) * camera.view_from(origin),
      glm::vec4(glm::vec3(camera.eye() - origin), static_cast<float>(camera.near_plane())),
      glm::vec4(glm::vec3(camera.axes() * kLight), options.lighting ? 1.0f : 0.0f),
      glm::vec4(static_cast<float>(2.0 * std::tan(0.5 * camera.fov_y) / size.y),
                frame_ && frame_->normals_estimated ? 1.0f : 0.0f, 0.0f, 0.0f)};
  glNamedBufferSubData(view_buffer_.name(), 0, sizeof(view), &view);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, view_buffer_.name());

  glViewport(0, 0, size.x, size.y);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_GREATER);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_FRAMEBUFFER_SRGB);
  for (const GLenum off : {GL_BLEND, GL_CULL_FACE, GL_SCISSOR_TEST, GL_STENCIL_TEST}) {
    glDisable(off);
  }
  const std::array<GLfloat, 4> background = {linear_from_srgb(options.background.x),
                                             linear_from_srgb(options.background.y),
                                             linear_from_srgb(options.background.z), 1.0f};
  const GLfloat infinity = 0.0f;
  glClearNamedFramebufferfv(picture_.name(), GL_COLOR, 0, background.data());
  glClearNamedFramebufferfv(picture_.name(), GL_DEPTH, 0, &infinity);
  if (stats.drawn > 0) {
    switch (mode_) {
      case DrawMode::surfel:
        draw_surfels(options);
        break;
      case DrawMode::voxel:
        draw_voxels();
        break;
      case DrawMode::point:
        draw_points(options);
        break;
    }
  }
  glDisable(GL_FRAMEBUFFER_SRGB);
  glFinish();
  stats.render_ms = milliseconds_since(start) - stats.cut_ms;
  return stats;
}

/// Paper 2, section V-B, with ERRATA 9 to 11: depth first, pushed back; then the sums of the splats
/// that lie in front of it; then their weighted mean.
void Renderer::draw_surfels(const DrawOptions& options) const {
  const auto count = static_cast<GLsizei>(instances_.items.size());
  glBindVertexArray(per_instance_.name());
  glBindFramebuffer(GL_FRAMEBUFFER, splats_.name());
  const std::array<GLfloat, 4> nothing{};
  glClearNamedFramebufferfv(splats_.name(), GL_COLOR, 0, nothing.data());

  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glUseProgram(visibility_.name());
  glUniform1f(0, options.visibility_scale);
  glUniform1f(1, kDepthTolerance);
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, count);

  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFunc(GL_ONE, GL_ONE);
  glUseProgram(splat_.name());
  glUniform1f(0, options.shading_scale);
  glUniform1f(1, 0.0f);
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, count);

  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  glBindTextureUnit(0, sums_.name());
  glUseProgram(resolve_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void Renderer::draw_voxels() const {
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  glBindVertexArray(per_instance_.name());
  glEnable(GL_CULL_FACE);
  glCullFace(GL_BACK);
  glFrontFace(GL_CCW);
  glProvokingVertex(GL_LAST_VERTEX_CONVENTION);
  glUseProgram(voxel_.name());
  glDrawArraysInstanced(GL_TRIANGLE_FAN, 0, 8, static_cast<GLsizei>(instances_.items.size()));
}

void Renderer::draw_points(const DrawOptions& options) const {
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  glBindVertexArray(per_vertex_.name());
  glEnable(GL_PROGRAM_POINT_SIZE);
  glUseProgram(point_.name());
  glUniform1f(0, options.point_size);
  glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(instances_.items.size()));
}

void Renderer::present(GLuint framebuffer) const {
  // Bytes as they are: without GL_FRAMEBUFFER_SRGB neither side converts.
  glDisable(GL_FRAMEBUFFER_SRGB);
  glDisable(GL_SCISSOR_TEST);
  glBlitNamedFramebuffer(picture_.name(), framebuffer, 0, 0, size_.x, size_.y, 0, 0, size_.x,
                         size_.y, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

Result<Image> Renderer::read_pixels() const {
  if (size_.x == 0) return fail("there is no picture yet");
  Image bottom_up, image;
  image.width = size_.x;
  image.height = size_.y;
  const auto row = static_cast<std::size_t>(size_.x);
  image.pixels.resize(row * static_cast<std::size_t>(size_.y));
  bottom_up.pixels.resize(image.pixels.size());
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureImage(color_.name(), 0, GL_RGB, GL_UNSIGNED_BYTE,
                    static_cast<GLsizei>(bottom_up.pixels.size() * sizeof(glm::u8vec3)),
                    bottom_up.pixels.data());
  for (int y = 0; y < size_.y; ++y) {
    const auto from = bottom_up.pixels.begin() + static_cast<std::ptrdiff_t>(row) *
                                                     static_cast<std::ptrdiff_t>(size_.y - 1 - y);
    std::copy(from, from + static_cast<std::ptrdiff_t>(row),
              image.pixels.begin() + static_cast<std::ptrdiff_t>(row) * y);
  }
  return image;
}

}  // namespace pointreel
