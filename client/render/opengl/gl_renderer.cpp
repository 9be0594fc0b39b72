#include "client/render/opengl/gl_renderer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "client/render/milliseconds_since.h"
#include "client/render/opengl/instancing/instance_array.h"
#include "client/render/pick.h"
#include "client/render/srgb.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// The same view, in which elements have their normals for colours.
PictureView with_normals(PictureView view) {
  view.light.w = kShowNormals;
  return view;
}

void cull_backs() {
  glEnable(GL_CULL_FACE);
  glCullFace(GL_BACK);
  glFrontFace(GL_CCW);
}

}  // namespace

Result<GlRenderer> GlRenderer::create() {
  if (epoxy_gl_version() < 45 || !epoxy_is_desktop_gl()) {
    return fail(ErrorCode::unsupported,
                "OpenGL 4.5 is needed to draw, but this context is " + describe_opengl());
  }
  return GlRenderer();
}

GlRenderer::GlRenderer()
    : point_({{GL_VERTEX_SHADER,
               {"instancing/shaders/instance.glsl", "instancing/attribute/fetch.glsl",
                "shaders/point.vert.glsl"}},
              {GL_FRAGMENT_SHADER, {"shaders/point.frag.glsl"}}}),
      points_(make_instance_array(0)),
      view_buffer_(gl::Buffer::create()) {
  glNamedBufferStorage(view_buffer_.name(), sizeof(PictureView), nullptr, GL_DYNAMIC_STORAGE_BIT);
}

InstancingMethod& GlRenderer::method_for(Instancing instancing) {
  auto& method = methods_[static_cast<std::size_t>(instancing)];
  if (!method) method = make_instancing(instancing);
  return *method;
}

Result<void> GlRenderer::resize(glm::ivec2 size) {
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

Result<DrawStats> GlRenderer::draw(const Scene& scene, const Camera& camera, glm::ivec2 shown,
                                   const DrawOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const glm::ivec2 size = (shown + options.reduction - 1) / options.reduction;
  TRY(resize(size));
  TRY(instances_.update(scene, camera, size,
                        {options.mode, options.color, options.fill_holes, options.refine},
                        options.pixel_size, buffer_));
  DrawStats stats;
  stats.drawn = static_cast<std::uint32_t>(buffer_.size());
  stats.visited = instances_.stats().visited;
  stats.out_of_view = instances_.stats().out_of_view;
  stats.below_pixel = instances_.stats().below_pixel;
  stats.hidden = instances_.stats().hidden;
  stats.cut_ms = instances_.stats().cut_ms;
  if (options.mode == DrawMode::strip) {
    strips_.update(scene, camera, size, options, instances_, stats);
    TRY(strip_passes_.set(strips_, instances_.normals_estimated()));
  }

  camera_ = camera;
  shown_ = shown;
  background_ = options.background;
  const bool late = is_shaded_late(options) && stats.drawn > 0;
  const PictureView view =
      make_view(camera, instances_.origin(), size,
                light_strength(options.lighting && !late, instances_.colored()),
                instances_.normals_estimated());
  const PixelRect region = elements_region(options, instances_.bounds(), view.to_clip, size);
  drawn_on_ = options.floor ? PixelRect{glm::ivec2(0), size} : region;
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
  if (late) {
    const LightProbe& probe = probes_.probe(options);
    TRY(late_light_.begin(
        size, depth_,
        make_shading(options, probe, camera, instances_.bounds(), instances_.origin()), probe,
        buffer_));
  }
  const auto floor = [&]() -> Result<void> {
    TRY(draw_floor(*options.floor, camera, options));
    if (!late || options.light == Light::flat) return {};
    set_view(view);
    glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
    TRY(late_light_.shade_floor());
    glEnable(GL_DEPTH_TEST);
    return {};
  };
  if (above_floor) TRY(floor());
  if (stats.drawn > 0) {
    set_view(view);
    TRY(draw_instances(view, region, options));
    if (options.smooth_outlines) {
      TRY(outlines_.draw(region));
      glEnable(GL_DEPTH_TEST);
    }
  }
  if (options.floor && !above_floor) TRY(floor());
  glDisable(GL_FRAMEBUFFER_SRGB);
  // Waiting here means that the picture appears without a queue of others before it, that its time
  // is exact on every driver, and that one buffer for instances is enough. On software OpenGL it
  // costs no frame rate, since drawing keeps all processors busy. Timer queries are no replacement
  // there: those of llvmpipe miss nearly all the time that points take.
  glFinish();
  stats.render_ms = milliseconds_since(start) - stats.cut_ms;
  return stats;
}

void GlRenderer::set_view(const PictureView& view) const {
  glNamedBufferSubData(view_buffer_.name(), 0, sizeof(view), &view);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, view_buffer_.name());
}

Result<void> GlRenderer::draw_floor(const FloorGrid& grid, const Camera& camera,
                                    const DrawOptions& options) {
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  set_view(make_view(camera, floor_origin(grid), size_, 0.0f, false));
  auto drawn = floor_.draw(grid, camera, options.background);
  glEnable(GL_DEPTH_TEST);
  return drawn;
}

Result<void> GlRenderer::draw_instances(const PictureView& view, const PixelRect& region,
                                        const DrawOptions& options) {
  const bool late = is_shaded_late(options);
  const auto show_normals = [&] { set_view(with_normals(view)); };
  const auto draw_elements = [&] {
    return options.mode == DrawMode::point ? draw_points(options) : draw_voxels(options);
  };
  if (options.mode == DrawMode::surfel) {
    TRY(draw_surfels(view, region, options));
  } else if (options.mode == DrawMode::strip) {
    const SplatLight light{late_light_, show_normals};
    TRY(draw_strips(view, region, options, late ? &light : nullptr));
    set_view(view);
  } else if (late) {
    TRY(splatter_.draw_lit(draw_elements, {late_light_, show_normals}, region));
    set_view(view);
  } else {
    glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
    TRY(draw_elements());
  }
  if (options.edl <= 0.0f) return {};
  const bool means =
      (options.mode == DrawMode::surfel && options.splatting == Splatting::normalized) ||
      (options.mode == DrawMode::strip && (options.fill_holes || late));
  return eye_dome_.draw(options.edl, means ? &splatter_.sums() : nullptr);
}

Result<void> GlRenderer::draw_surfels(const PictureView& view, const PixelRect& region,
                                      const DrawOptions& options) {
  InstancingMethod& method = method_for(options.instancing);
  const SplatScales scales = scales_of(options.splatting, options.scales);
  cull_backs();
  method.begin(std::max(scales.visibility, scales.shading));
  const SplatLight late{late_light_, [&] {
                          set_view(with_normals(view));
                          method.begin(std::max(scales.visibility, scales.shading));
                        }};
  auto drawn = splatter_.draw(method, buffer_, options.splatting, scales, options.fill_holes,
                              splat_place(view, region), is_shaded_late(options) ? &late : nullptr);
  set_view(view);
  glDisable(GL_CULL_FACE);
  return drawn;
}

SplatPlace GlRenderer::splat_place(const PictureView& view, const PixelRect& region) const {
  const InstanceBounds& bounds = instances_.bounds();
  return {.region = region,
          .radius = static_cast<float>(bounds.mean_radius()),
          .pixels = radius_in_pixels(bounds, view.to_clip, size_),
          .nearest = nearest_depth(bounds, view.to_clip, view.eye.w),
          .signs_unknown = instances_.normals_estimated(),
          .one_back_in = instances_.one_back_in()};
}

Result<void> GlRenderer::draw_strips(const PictureView& view, const PixelRect& region,
                                     const DrawOptions& options, const SplatLight* late) {
  glFrontFace(GL_CCW);
  return splatter_.draw_strips(
      strip_passes_, buffer_, [this] { return draw_points(strip_passes_.points(), 1.0f, 0.0f); },
      options.fill_holes, splat_place(view, region), late);
}

Result<void> GlRenderer::draw_voxels(const DrawOptions& options) {
  InstancingMethod& method = method_for(options.instancing);
  cull_backs();
  method.begin(1.0f);
  glProvokingVertex(GL_LAST_VERTEX_CONVENTION);
  auto drawn = method.draw(
      buffer_, options.voxel_shape == VoxelShape::cube ? Pass::voxel_cube : Pass::voxel_faces, {});
  glDisable(GL_CULL_FACE);
  return drawn;
}

Result<void> GlRenderer::draw_points(const DrawOptions& options) {
  const auto reduction = static_cast<float>(options.reduction);
  return draw_points(buffer_, std::max(1.0f, options.point_size / reduction),
                     options.adaptive_points ? kLargestPoint / reduction : 0.0f);
}

Result<void> GlRenderer::draw_points(const InstanceBuffer& points, float least, float largest) {
  if (points.size() == 0) return {};
  TRY(point_.use());
  bind_instance_array(points_, points);
  glEnable(GL_PROGRAM_POINT_SIZE);
  glUniform1f(0, least);
  glUniform1f(1, largest);
  glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(points.size()));
  return {};
}

void GlRenderer::present(unsigned framebuffer) {
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

std::optional<glm::dvec3> GlRenderer::point_at(const glm::dvec2& pixel) const {
  if (size_.x == 0) return std::nullopt;
  // In pixels of the drawn picture, from the lower left corner.
  const glm::dvec2 at =
      glm::dvec2(pixel.x, shown_.y - pixel.y) * glm::dvec2(size_) / glm::dvec2(shown_);
  const PixelRect area = pick_area(at, size_);
  if (area.empty()) return std::nullopt;
  const glm::ivec2 extent = area.max - area.min;
  std::vector<float> depths(static_cast<std::size_t>(extent.x * extent.y));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureSubImage(depth_.name(), 0, area.min.x, area.min.y, 0, extent.x, extent.y, 1,
                       GL_DEPTH_COMPONENT, GL_FLOAT,
                       static_cast<GLsizei>(depths.size() * sizeof(float)), depths.data());
  return pick(at, area, depths, camera_, size_);
}

Result<Image> GlRenderer::read_pixels() const {
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
