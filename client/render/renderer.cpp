#include "client/render/renderer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "client/render/gl_context.h"
#include "client/render/instances.h"
#include "client/render/instancing/instance_array.h"
#include "client/render/srgb.h"

namespace pointreel {
namespace {

/// Towards the light, in eye space: over the viewer's left shoulder.
const glm::dvec3 kLight = glm::normalize(glm::dvec3(-0.35, 0.45, 1.0));

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

}  // namespace

Result<Renderer> Renderer::create() {
  if (epoxy_gl_version() < 45 || !epoxy_is_desktop_gl()) {
    return fail("OpenGL 4.5 is needed to draw, but this context is " + describe_opengl());
  }
  Renderer renderer;
  auto splatter = Splatter::create();
  if (!splatter) return fail(splatter.error().message);
  renderer.splatter_ = std::move(*splatter);
  auto eye_dome = EyeDomeLighting::create();
  if (!eye_dome) return fail(eye_dome.error().message);
  renderer.eye_dome_ = std::move(*eye_dome);
  auto point = gl::make_program(
      std::array{gl::Stage{GL_VERTEX_SHADER,
                           {"instancing/shaders/instance.glsl", "instancing/attribute/fetch.glsl",
                            "shaders/point.vert.glsl"}},
                 gl::Stage{GL_FRAGMENT_SHADER, {"shaders/flat.frag.glsl"}}});
  if (!point) return fail(point.error().message);
  renderer.point_ = std::move(*point);
  renderer.points_ = make_instance_array(0);
  renderer.view_buffer_ = gl::Buffer::create();
  glNamedBufferStorage(renderer.view_buffer_.name(), sizeof(ViewBlock), nullptr,
                       GL_DYNAMIC_STORAGE_BIT);
  return renderer;
}

Result<InstancingMethod*> Renderer::method_for(Instancing instancing) {
  auto& method = methods_[static_cast<std::size_t>(instancing)];
  if (!method) {
    auto made = make_instancing(instancing);
    if (!made) return fail(made.error().message);
    method = std::move(*made);
  }
  return method.get();
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
  gl::Texture depth = gl::make_texture(GL_DEPTH_COMPONENT32F, size.x, size.y);
  Result<gl::Framebuffer> picture = gl::make_framebuffer(color, depth);
  if (!picture) return fail(picture.error().message);
  if (auto resized = splatter_->resize(size, color, depth); !resized) return resized;
  if (auto resized = eye_dome_->resize(color, depth); !resized) return resized;
  picture_ = std::move(*picture);
  color_ = std::move(color);
  depth_ = std::move(depth);
  size_ = size;
  return {};
}

Result<void> Renderer::update_instances(std::shared_ptr<const SceneFrame> frame,
                                        const Camera& camera, const DrawOptions& options,
                                        DrawStats& stats) {
  const bool same = frame == frame_ && options.mode == mode_;
  frame_ = std::move(frame);
  mode_ = options.mode;
  const bool tree = frame_ && (mode_ == DrawMode::voxel || frame_->cloud.empty());
  if (tree) {
    const CutKey key{camera, size_, options.pixel_size};
    if (same && cut_key_ == key) return {};
    cut_key_ = key;
    const auto start = std::chrono::steady_clock::now();
    cut_stats_ = cut_.run(frame_->svo, camera, size_, options.pixel_size);
    stats.cut_ms = milliseconds_since(start);
  } else if (same) {
    return {};
  } else {
    cut_stats_ = {};
  }
  const std::size_t count = !frame_ ? 0 : tree ? cut_.nodes().size() : frame_->cloud.size();
  const std::span<Instance> out = instances_.write(count);
  if (out.size() < count) {
    frame_.reset();
    cut_stats_ = {};
    return fail("the graphics driver has no memory for " + std::to_string(count) + " elements");
  }
  if (tree) {
    origin_ = frame_->svo.cube.origin;
    const glm::vec3 eye(camera.eye() - origin_);
    const PackedNodes packed = pack_nodes(*frame_, cut_.nodes(), mode_, eye, out);
    instances_.keep(packed.count);
    bounds_ = packed.bounds;
  } else if (frame_) {
    origin_ = frame_->cloud.origin;
    bounds_ = pack_points(*frame_, out);
  }
  return {};
}

Result<DrawStats> Renderer::draw(std::shared_ptr<const SceneFrame> frame, const Camera& camera,
                                 glm::ivec2 size, const DrawOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  if (Result<void> resized = resize(size); !resized) return fail(resized.error().message);
  DrawStats stats;
  if (auto updated = update_instances(std::move(frame), camera, options, stats); !updated)
    return fail(updated.error().message);
  stats.drawn = static_cast<std::uint32_t>(instances_.size());
  stats.visited = cut_stats_.visited;
  stats.out_of_view = cut_stats_.out_of_view;
  if (stats.visited > 0)
    stats.below_pixel = frame_->svo.leaf_count() - stats.out_of_view - cut_stats_.emitted;
  if (stats.visited > 0) stats.hidden = cut_stats_.emitted - stats.drawn;

  const glm::dmat3 axes = camera.axes();
  const double slope = std::tan(0.5 * camera.fov_y), step = 2.0 * slope / size.y;
  const ViewBlock view{
      camera.projection(static_cast<double>(size.x) / size.y) * camera.view_from(origin_),
      glm::vec4(glm::vec3(camera.eye() - origin_), static_cast<float>(camera.near_plane())),
      glm::vec4(glm::vec3(axes * kLight), options.lighting ? 1.0f : 0.0f),
      glm::vec4(static_cast<float>(step), frame_ && frame_->normals_estimated ? 1.0f : 0.0f, 0.0f,
                0.0f),
      glm::vec4(glm::vec3(-axes[2] - 0.5 * step * size.x * axes[0] - slope * axes[1]), 0.0f),
      glm::vec4(glm::vec3(step * axes[0]), 0.0f),
      glm::vec4(glm::vec3(step * axes[1]), 0.0f),
      glm::vec4(glm::vec2(size), 0.0f, 0.0f)};
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
                                             linear_from_srgb(options.background.z), 0.0f};
  const GLfloat infinity = 0.0f;
  glClearNamedFramebufferfv(picture_.name(), GL_COLOR, 0, background.data());
  glClearNamedFramebufferfv(picture_.name(), GL_DEPTH, 0, &infinity);
  if (stats.drawn > 0) {
    if (auto drawn = draw_instances(options, view.to_clip); !drawn)
      return fail(drawn.error().message);
    const bool means = mode_ == DrawMode::surfel && options.splatting == Splatting::normalized;
    if (options.edl > 0.0f) eye_dome_->draw(options.edl, means ? &splatter_->sums() : nullptr);
    instances_.drawn();
  }
  glDisable(GL_FRAMEBUFFER_SRGB);
  glFinish();
  stats.render_ms = milliseconds_since(start) - stats.cut_ms;
  return stats;
}

Result<void> Renderer::draw_instances(const DrawOptions& options, const glm::mat4& to_clip) {
  if (mode_ == DrawMode::point) {
    draw_points(options);
    return {};
  }
  const Result<InstancingMethod*> method = method_for(options.instancing);
  if (!method) return fail(method.error().message);
  glEnable(GL_CULL_FACE);
  glCullFace(GL_BACK);
  glFrontFace(GL_CCW);
  if (mode_ == DrawMode::surfel) {
    const SplatScales scales = scales_of(options.splatting, options.scales);
    const float largest_scale = std::max(scales.visibility, scales.shading);
    (*method)->begin(largest_scale);
    // The corners of a quad are farther out than the rim of its disc.
    const SplatPlace place{region_of(bounds_, 1.5f * largest_scale, to_clip, size_),
                           radius_in_pixels(bounds_, to_clip, size_)};
    splatter_->draw(**method, instances_, options.splatting, scales, options.fill_holes, place);
  } else {
    (*method)->begin(1.0f);
    glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
    glProvokingVertex(GL_LAST_VERTEX_CONVENTION);
    (*method)->draw(instances_,
                    options.voxel_shape == VoxelShape::cube ? Pass::voxel_cube : Pass::voxel_faces,
                    {});
  }
  glDisable(GL_CULL_FACE);
  return {};
}

void Renderer::draw_points(const DrawOptions& options) const {
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  bind_instance_array(points_, instances_);
  glEnable(GL_PROGRAM_POINT_SIZE);
  glUseProgram(point_.name());
  glUniform1f(0, options.point_size);
  glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(instances_.size()));
}

void Renderer::present(GLuint framebuffer) const {
  // Bytes as they are: without GL_FRAMEBUFFER_SRGB neither side converts.
  glDisable(GL_FRAMEBUFFER_SRGB);
  glDisable(GL_SCISSOR_TEST);
  glBlitNamedFramebuffer(picture_.name(), framebuffer, 0, 0, size_.x, size_.y, 0, 0, size_.x,
                         size_.y, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

Result<std::vector<glm::u8vec4>> Renderer::read_picture() const {
  if (size_.x == 0) return fail("there is no picture yet");
  const auto row = static_cast<std::ptrdiff_t>(size_.x);
  std::vector<glm::u8vec4> pixels(static_cast<std::size_t>(row * size_.y));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureImage(color_.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE,
                    static_cast<GLsizei>(pixels.size() * sizeof(glm::u8vec4)), pixels.data());
  // From bottom up to top down.
  for (int y = 0; y < size_.y / 2; ++y) {
    const auto upper = pixels.begin() + row * y, lower = pixels.begin() + row * (size_.y - 1 - y);
    std::swap_ranges(upper, upper + row, lower);
  }
  return pixels;
}

Result<Image> Renderer::read_pixels() const {
  const auto picture = read_picture();
  if (!picture) return fail(picture.error().message);
  Image image;
  image.width = size_.x;
  image.height = size_.y;
  image.pixels.reserve(picture->size());
  for (const glm::u8vec4& pixel : *picture) image.pixels.emplace_back(pixel);
  return image;
}

Result<std::vector<std::uint8_t>> Renderer::read_alpha() const {
  const auto picture = read_picture();
  if (!picture) return fail(picture.error().message);
  std::vector<std::uint8_t> alpha;
  alpha.reserve(picture->size());
  for (const glm::u8vec4& pixel : *picture) alpha.push_back(pixel.a);
  return alpha;
}

}  // namespace pointreel
