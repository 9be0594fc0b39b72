#include "client/render/renderer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "client/render/gl_context.h"
#include "client/render/instancing/instance_array.h"
#include "client/render/srgb.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// The direction to the light in eye space, over the viewer's left shoulder.
const glm::dvec3 kLight = glm::normalize(glm::dvec3(-0.35, 0.45, 1.0));

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

bool is_above(const glm::dvec3& eye, const FloorGrid& grid) {
  return glm::dot(eye - floor_origin(grid), grid.up.direction()) >= 0.0;
}

void cull_backs() {
  glEnable(GL_CULL_FACE);
  glCullFace(GL_BACK);
  glFrontFace(GL_CCW);
}

/// Distance of a cube's corner from its centre, in halves of the edge.
constexpr float kCubeCorner = 1.7321f;

/// How many pixels away point_at searches.
constexpr int kPickReach = 8;

}  // namespace

Result<Renderer> Renderer::create() {
  if (epoxy_gl_version() < 45 || !epoxy_is_desktop_gl()) {
    return fail(ErrorCode::unsupported,
                "OpenGL 4.5 is needed to draw, but this context is " + describe_opengl());
  }
  return Renderer();
}

Renderer::Renderer()
    : point_({{GL_VERTEX_SHADER,
               {"instancing/shaders/instance.glsl", "instancing/attribute/fetch.glsl",
                "shaders/point.vert.glsl"}},
              {GL_FRAGMENT_SHADER, {"shaders/flat.frag.glsl"}}}),
      points_(make_instance_array(0)),
      view_buffer_(gl::Buffer::create()) {
  glNamedBufferStorage(view_buffer_.name(), sizeof(ViewBlock), nullptr, GL_DYNAMIC_STORAGE_BIT);
}

InstancingMethod& Renderer::method_for(Instancing instancing) {
  auto& method = methods_[static_cast<std::size_t>(instancing)];
  if (!method) method = make_instancing(instancing);
  return *method;
}

Result<void> Renderer::resize(glm::ivec2 size) {
  if (size == size_) return {};
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (size.x < 1 || size.y < 1 || size.x > largest || size.y > largest) {
    return fail(ErrorCode::argument, "a picture of " + std::to_string(size.x) + "x" +
                                         std::to_string(size.y) +
                                         " pixels cannot be drawn: width and height must be 1 to " +
                                         std::to_string(largest));
  }
  gl::Texture color = gl::make_texture(GL_SRGB8_ALPHA8, size.x, size.y);
  gl::Texture depth = gl::make_texture(GL_DEPTH_COMPONENT32F, size.x, size.y);
  gl::Framebuffer picture = TRY(gl::make_framebuffer(color, depth));
  TRY(splatter_.resize(size, color, depth));
  TRY(eye_dome_.resize(color, depth));
  TRY(outlines_.resize(size, color));
  view_ = gl::view_texture(color, GL_RGBA8);
  picture_ = std::move(picture);
  color_ = std::move(color);
  depth_ = std::move(depth);
  size_ = size;
  return {};
}

Result<DrawStats> Renderer::draw(std::shared_ptr<const SceneFrame> frame, const Camera& camera,
                                 glm::ivec2 size, const DrawOptions& options) {
  return draw(Scene{{std::move(frame)}}, camera, size, options);
}

Result<DrawStats> Renderer::draw(const Scene& scene, const Camera& camera, glm::ivec2 shown,
                                 const DrawOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const glm::ivec2 size = (shown + options.reduction - 1) / options.reduction;
  TRY(resize(size));
  TRY(instances_.update(scene, camera, size,
                        {options.mode, options.color, options.fill_holes, options.refine},
                        options.pixel_size));
  DrawStats stats;
  stats.reduction = options.reduction;
  stats.drawn = static_cast<std::uint32_t>(instances_.buffer().size());
  stats.visited = instances_.stats().visited;
  stats.out_of_view = instances_.stats().out_of_view;
  stats.below_pixel = instances_.stats().below_pixel;
  stats.hidden = instances_.stats().hidden;
  stats.cut_ms = instances_.stats().cut_ms;

  camera_ = camera;
  shown_ = shown;
  background_ = options.background;
  drawn_on_ = options.floor ? PixelRect{glm::ivec2(0), size} : instances_region(options);
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
  const bool above_floor = options.floor && is_above(camera.eye(), *options.floor);
  if (above_floor) TRY(draw_floor(*options.floor, camera, options));
  if (stats.drawn > 0) {
    set_view(camera, instances_.origin(), options.lighting);
    TRY(draw_instances(camera, options));
    if (options.smooth_outlines) {
      TRY(outlines_.draw(instances_region(options)));
      glEnable(GL_DEPTH_TEST);
    }
  }
  if (options.floor && !above_floor) TRY(draw_floor(*options.floor, camera, options));
  glDisable(GL_FRAMEBUFFER_SRGB);
  // Waiting here means that the picture appears without a queue of others before it, that its time
  // is exact on every driver, and that one buffer for instances is enough. On software OpenGL it
  // costs no frame rate, since drawing keeps all processors busy. Timer queries are no replacement
  // there: those of llvmpipe miss nearly all the time that points take.
  glFinish();
  stats.render_ms = milliseconds_since(start) - stats.cut_ms;
  return stats;
}

glm::mat4 Renderer::clip_from(const Camera& camera, const glm::dvec3& origin) const {
  return camera.projection(static_cast<double>(size_.x) / size_.y) * camera.view_from(origin);
}

void Renderer::set_view(const Camera& camera, const glm::dvec3& origin, bool lighting) const {
  const glm::dmat3 axes = camera.axes();
  const double slope = std::tan(0.5 * camera.fov_y), step = 2.0 * slope / size_.y;
  const ViewBlock view{
      clip_from(camera, origin),
      glm::vec4(glm::vec3(camera.eye() - origin), static_cast<float>(camera.near_plane())),
      glm::vec4(glm::vec3(axes * kLight), lighting ? 1.0f : 0.0f),
      glm::vec4(static_cast<float>(step), instances_.normals_estimated() ? 1.0f : 0.0f, 0.0f, 0.0f),
      glm::vec4(glm::vec3(-axes[2] - 0.5 * step * size_.x * axes[0] - slope * axes[1]), 0.0f),
      glm::vec4(glm::vec3(step * axes[0]), 0.0f),
      glm::vec4(glm::vec3(step * axes[1]), 0.0f),
      glm::vec4(glm::vec2(size_), 0.0f, 0.0f)};
  glNamedBufferSubData(view_buffer_.name(), 0, sizeof(view), &view);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, view_buffer_.name());
}

Result<void> Renderer::draw_floor(const FloorGrid& grid, const Camera& camera,
                                  const DrawOptions& options) {
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  set_view(camera, floor_origin(grid), options.lighting);
  auto drawn = floor_.draw(grid, camera, options.background);
  glEnable(GL_DEPTH_TEST);
  return drawn;
}

Result<void> Renderer::draw_instances(const Camera& camera, const DrawOptions& options) {
  TRY(options.mode == DrawMode::point    ? draw_points(options)
      : options.mode == DrawMode::surfel ? draw_surfels(camera, options)
                                         : draw_voxels(options));
  if (options.edl <= 0.0f) return {};
  const bool means = options.mode == DrawMode::surfel && options.splatting == Splatting::normalized;
  return eye_dome_.draw(options.edl, means ? &splatter_.sums() : nullptr);
}

PixelRect Renderer::instances_region(const DrawOptions& options) const {
  if (instances_.buffer().size() == 0) return {};
  const glm::mat4 to_clip = clip_from(camera_, instances_.origin());
  switch (options.mode) {
    case DrawMode::surfel: {
      // Quads are drawn around the discs, and their corners are farther out.
      const SplatScales scales = scales_of(options.splatting, options.scales);
      const float scale = 1.5f * std::max(scales.visibility, scales.shading);
      return region_of(instances_.bounds(), scale, to_clip, size_);
    }
    case DrawMode::voxel:  // no voxel is drawn smaller than a pixel
      return region_of(instances_.bounds(), kCubeCorner, to_clip, size_, 1);
    case DrawMode::point:
      return region_of(instances_.bounds(), 0.0f, to_clip, size_,
                       static_cast<int>(std::ceil(0.5f * options.point_size)));
  }
  return {};
}

Result<void> Renderer::draw_surfels(const Camera& camera, const DrawOptions& options) {
  InstancingMethod& method = method_for(options.instancing);
  const glm::mat4 to_clip = clip_from(camera, instances_.origin());
  const SplatScales scales = scales_of(options.splatting, options.scales);
  cull_backs();
  method.begin(std::max(scales.visibility, scales.shading));
  const InstanceBounds& bounds = instances_.bounds();
  const SplatPlace place{
      .region = instances_region(options),
      .radius = static_cast<float>(bounds.mean_radius()),
      .pixels = radius_in_pixels(bounds, to_clip, size_),
      .nearest = nearest_depth(bounds, to_clip, static_cast<float>(camera.near_plane())),
      .signs_unknown = instances_.normals_estimated()};
  auto drawn = splatter_.draw(method, instances_.buffer(), options.splatting, scales,
                              options.fill_holes, place);
  glDisable(GL_CULL_FACE);
  return drawn;
}

Result<void> Renderer::draw_voxels(const DrawOptions& options) {
  InstancingMethod& method = method_for(options.instancing);
  cull_backs();
  method.begin(1.0f);
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  glProvokingVertex(GL_LAST_VERTEX_CONVENTION);
  auto drawn = method.draw(
      instances_.buffer(),
      options.voxel_shape == VoxelShape::cube ? Pass::voxel_cube : Pass::voxel_faces, {});
  glDisable(GL_CULL_FACE);
  return drawn;
}

Result<void> Renderer::draw_points(const DrawOptions& options) {
  TRY(point_.use());
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  bind_instance_array(points_, instances_.buffer());
  glEnable(GL_PROGRAM_POINT_SIZE);
  glUniform1f(0, std::max(1.0f, options.point_size / static_cast<float>(options.reduction)));
  glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(instances_.buffer().size()));
  return {};
}

void Renderer::present(GLuint framebuffer) const {
  // Without GL_FRAMEBUFFER_SRGB the bytes are copied without conversion.
  glDisable(GL_FRAMEBUFFER_SRGB);
  glDisable(GL_SCISSOR_TEST);
  // On software OpenGL, clearing takes a twentieth of the time of copying.
  const std::array<GLfloat, 4> background = {background_.x, background_.y, background_.z, 1.0f};
  glClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, background.data());
  if (drawn_on_.empty()) return;
  const auto [from, to] = drawn_on_;
  const glm::ivec2 shown_from = from * shown_ / size_, shown_to = to * shown_ / size_;
  glBlitNamedFramebuffer(picture_.name(), framebuffer, from.x, from.y, to.x, to.y, shown_from.x,
                         shown_from.y, shown_to.x, shown_to.y, GL_COLOR_BUFFER_BIT,
                         size_ == shown_ ? GL_NEAREST : GL_LINEAR);
}

std::optional<glm::dvec3> Renderer::point_at(const glm::dvec2& pixel) const {
  if (size_.x == 0) return std::nullopt;
  // In pixels of the drawn picture, from the lower left corner.
  const glm::dvec2 at =
      glm::dvec2(pixel.x, shown_.y - pixel.y) * glm::dvec2(size_) / glm::dvec2(shown_);
  if (!(at.x >= 0.0 && at.x <= size_.x && at.y >= 0.0 && at.y <= size_.y)) return std::nullopt;
  const glm::ivec2 middle = glm::min(glm::ivec2(at), size_ - 1);
  const glm::ivec2 first = glm::max(middle - kPickReach, 0);
  const glm::ivec2 extent = glm::min(middle + kPickReach + 1, size_) - first;
  std::vector<float> depth(static_cast<std::size_t>(extent.x * extent.y));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureSubImage(depth_.name(), 0, first.x, first.y, 0, extent.x, extent.y, 1,
                       GL_DEPTH_COMPONENT, GL_FLOAT,
                       static_cast<GLsizei>(depth.size() * sizeof(float)), depth.data());
  double nearest = kPickReach + 0.5;
  glm::dvec2 found(0.0);
  float found_depth = 0.0f;
  for (int y = 0; y < extent.y; ++y) {
    for (int x = 0; x < extent.x; ++x) {
      const float there = depth[static_cast<std::size_t>(y * extent.x + x)];
      const glm::ivec2 here = first + glm::ivec2(x, y);
      const double away = glm::length(glm::dvec2(here - middle));
      if (!(there > 0.0f) || away >= nearest) continue;
      nearest = away;
      found = here == middle ? at : glm::dvec2(here) + 0.5;
      found_depth = there;
    }
  }
  if (found_depth == 0.0f) return std::nullopt;
  const double t = std::tan(0.5 * camera_.fov_y), away = camera_.near_plane() / found_depth;
  const glm::dvec2 in_picture = (2.0 * found - glm::dvec2(size_)) / static_cast<double>(size_.y);
  const glm::dmat3 axes = camera_.axes();
  return camera_.eye() + away * (t * (in_picture.x * axes[0] + in_picture.y * axes[1]) - axes[2]);
}

Result<Image> Renderer::read_pixels() const {
  if (size_.x == 0) return fail(ErrorCode::not_found, "there is no picture yet");
  const auto width = static_cast<std::size_t>(size_.x), height = static_cast<std::size_t>(size_.y);
  // With alpha, as the texture has it: drivers convert slowly.
  std::vector<glm::u8vec4> pixels(width * height);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureImage(color_.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE,
                    static_cast<GLsizei>(pixels.size() * sizeof(glm::u8vec4)), pixels.data());
  Image image{size_.x, size_.y, {}};
  image.pixels.reserve(pixels.size());
  // OpenGL's first row is the lowest.
  for (std::size_t row = height; row-- > 0;)
    for (std::size_t x = 0; x < width; ++x) image.pixels.emplace_back(pixels[row * width + x]);
  return image;
}

}  // namespace pointreel
