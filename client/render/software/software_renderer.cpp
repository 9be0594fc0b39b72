#include "client/render/software/software_renderer.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <new>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "client/render/hole_rules.h"
#include "client/render/milliseconds_since.h"
#include "client/render/pick.h"
#include "client/render/software/effects.h"
#include "client/render/software/raster.h"
#include "common/base/for_each.h"
#include "common/base/try.h"
#include "pointreel/cpu.h"

namespace pointreel {
namespace {

/// Below it, the sum of weights counts as nothing: it is less than the weight at the rim of a
/// splat, and more than rounding errors (shaders/mean.glsl).
constexpr float kNoWeight = 1e-6f;

constexpr int kMostPixels = 16384;  ///< width and height of a picture

/// Returns the milliseconds since its last call, or since it was made.
class Laps {
 public:
  double lap() {
    const auto before = std::exchange(begin_, std::chrono::steady_clock::now());
    return std::chrono::duration<double, std::milli>(begin_ - before).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

bool touches(const SplatBlock& block, int tile) {
  const auto any = [tile](const TileBins& bins) { return bins.begin(tile) != bins.end(tile); };
  return any(block.ellipse_bins) || any(block.disc_bins) || any(block.back_bins);
}

bool touches(const Splats& splats, int tile) {
  return std::any_of(splats.blocks().begin(), splats.blocks().end(),
                     [tile](const SplatBlock& block) { return touches(block, tile); });
}

/// Calls visit(pixel in the picture, index in the planes) for each pixel of a tile.
template <class Visit>
void each_pixel(const SplatTile& tile, const Picture& picture, const Visit& visit) {
  for (int y = tile.pixels.min.y; y < tile.pixels.max.y; ++y) {
    std::size_t pixel = picture.index(tile.pixels.min.x, y);
    auto at = static_cast<std::size_t>((y - tile.pixels.min.y) * kTileStride);
    for (int x = tile.pixels.min.x; x < tile.pixels.max.x; ++x) visit(pixel++, at++);
  }
}

}  // namespace

SoftwareRenderer::SoftwareRenderer(Executor executor)
    : executor_(std::move(executor)), instances_(executor_) {}

std::string SoftwareRenderer::describe() const {
  return fmt::format("software on {} threads{}", std::thread::hardware_concurrency(),
                     (cpu_features() & kCpuAvx2) != 0 ? " with AVX2" : "");
}

std::span<Instance> SoftwareRenderer::Memory::write(std::size_t count) {
  size_ = 0;
  try {
    if (memory_.size() < count) memory_.resize(count + count / 4);
  } catch (const std::bad_alloc&) {
    return {};
  }
  size_ = count;
  return {memory_.data(), count};
}

Result<void> SoftwareRenderer::resize(glm::ivec2 size) {
  if (size == picture_.grid.size) return {};
  if (size.x < 1 || size.y < 1 || size.x > kMostPixels || size.y > kMostPixels)
    return fail(ErrorCode::argument, "a picture of " + std::to_string(size.x) + "x" +
                                         std::to_string(size.y) +
                                         " pixels cannot be drawn: width and height must be 1 to " +
                                         std::to_string(kMostPixels));
  try {
    picture_ = Picture(size);
  } catch (const std::bad_alloc&) {
    picture_ = Picture();
    return fail(ErrorCode::limit, "there is no memory for a picture of " + std::to_string(size.x) +
                                      "x" + std::to_string(size.y) + " pixels");
  }
  return {};
}

void SoftwareRenderer::clear(const glm::vec3& background) {
  const glm::u8vec4 color(glm::round(255.0f * glm::clamp(background, 0.0f, 1.0f)), 0.0f);
  for_each(executor_, picture_.grid.tiles.y, [&](int row) {
    const std::size_t begin = picture_.index(0, row * kTileHeight);
    const std::size_t end =
        picture_.index(0, std::min((row + 1) * kTileHeight, picture_.grid.size.y));
    std::fill(picture_.colors.begin() + static_cast<std::ptrdiff_t>(begin),
              picture_.colors.begin() + static_cast<std::ptrdiff_t>(end), color);
    std::fill(picture_.depths.begin() + static_cast<std::ptrdiff_t>(begin),
              picture_.depths.begin() + static_cast<std::ptrdiff_t>(end), 0.0f);
  });
  std::fill(picture_.busy.begin(), picture_.busy.end(), std::uint8_t{0});
}

Result<DrawStats> SoftwareRenderer::draw(const Scene& scene, const Camera& camera, glm::ivec2 shown,
                                         const DrawOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const glm::ivec2 size = (shown + options.reduction - 1) / options.reduction;
  stages_ = {};
  Laps laps;
  TRY(resize(size));
  TRY(instances_.update(scene, camera, size,
                        {options.mode, options.color, options.fill_holes, options.refine},
                        options.pixel_size, memory_));
  DrawStats stats;
  stats.drawn = static_cast<std::uint32_t>(memory_.instances().size());
  stats.visited = instances_.stats().visited;
  stats.out_of_view = instances_.stats().out_of_view;
  stats.below_pixel = instances_.stats().below_pixel;
  stats.hidden = instances_.stats().hidden;
  stats.cut_ms = instances_.stats().cut_ms;
  if (options.mode == DrawMode::strip)
    strips_.update(scene, camera, size, options, instances_, stats);

  camera_ = camera;
  shown_ = shown;
  background_ = options.background;
  const bool late = is_shaded_late(options);
  const PictureView view =
      make_view(camera, instances_.origin(), size,
                light_strength(options.lighting && !late, instances_.colored()),
                instances_.normals_estimated());
  const PixelRect region = elements_region(options, instances_.bounds(), view.to_clip, size);
  drawn_on_ = options.floor ? PixelRect{glm::ivec2(0), size} : region;

  stages_.warp = laps.lap() - stats.cut_ms;
  clear(options.background);
  stages_.clear = laps.lap();
  std::optional<ShadingView> shading;
  picture_.normals.resize(late ? picture_.colors.size() : 0);
  if (late && stats.drawn > 0) {
    shading = make_shading(options, probes_.probe(options), camera, instances_.bounds(),
                           instances_.origin());
    if (options.light != Light::flat)
      shadow_.draw(memory_.instances(), shading->to_shadow, executor_);
    stages_.light = laps.lap();
  }
  const auto floor = [&] {
    draw_floor(*options.floor, camera,
               make_view(camera, floor_origin(*options.floor), size, 0.0f, false),
               options.background, picture_);
    if (shading && options.light != Light::flat)
      ScreenShading::shade_floor(*shading, shadow_, view, executor_, picture_);
  };
  const bool above_floor = options.floor && is_above(camera.eye(), *options.floor);
  if (above_floor) floor();
  if (stats.drawn > 0) {
    if (options.mode == DrawMode::surfel) {
      draw_surfels(view, shading ? &*shading : nullptr, options);
      laps.lap();
    } else if (options.mode == DrawMode::strip) {
      triangles_.draw(memory_.instances(), strips_,
                      options.fill_holes ? Triangles::Backs::depth : Triangles::Backs::none, view,
                      executor_, picture_);
      stages_.shading = laps.lap();
      close_surface(view, shading ? &*shading : nullptr, options);
      laps.lap();
    } else {
      const auto reduction = static_cast<float>(options.reduction);
      const float least = std::max(1.0f, options.point_size / reduction);
      const float most = options.adaptive_points ? kLargestPoint / reduction : 0.0f;
      solids_.draw(memory_.instances(), options.mode == DrawMode::voxel,
                   {least, std::max(least, most)}, view, executor_, picture_);
      stages_.shading = laps.lap();
      if (shading) light(view, *shading, options);
      laps.lap();
      if (options.edl > 0.0f) light_eye_dome(options.edl, executor_, picture_);
    }
    if (options.smooth_outlines) smooth_outlines(region, executor_, picture_);
    stages_.reconstruction += laps.lap();
  }
  if (options.floor && !above_floor) floor();
  stats.render_ms = milliseconds_since(start) - stats.cut_ms;
  return stats;
}

void SoftwareRenderer::light(const PictureView& view, const ShadingView& late,
                             const DrawOptions& options) {
  Laps laps;
  screen_shading_.light(late, probes_.probe(options), shadow_, view, executor_, picture_);
  stages_.light += laps.lap();
}

void SoftwareRenderer::draw_surfels(const PictureView& view, const ShadingView* late,
                                    const DrawOptions& options) {
  const Splatting splatting = options.splatting;
  const SplatScales scales = scales_of(splatting, options.scales);
  const bool two_passes = splatting != Splatting::regular && splatting != Splatting::no_depth;
  const bool means = splatting == Splatting::normalized, fills = options.fill_holes && means;
  const bool signs_unknown = instances_.normals_estimated();
  const auto instances = memory_.instances();

  Laps laps;
  const std::uint32_t one_in = fills && !signs_unknown ? instances_.one_back_in() : 0;
  color_splats_.set(
      instances, view, picture_.grid,
      {scales.shading, scales.shading == scales.visibility ? one_in : 0, !means, late != nullptr},
      executor_);
  const Splats* depth_splats = &color_splats_;
  if (two_passes && scales.visibility != scales.shading) {
    depth_splats_.set(instances, view, picture_.grid, {scales.visibility, one_in, !means, false},
                      executor_);
    depth_splats = &depth_splats_;
  }

  stages_.warp += laps.lap();

  // The two passes over each tile follow each other; how they share the time is summed over tiles.
  std::atomic<std::int64_t> first_pass{0}, both_passes{0};
  const SplatKernels& kernels = splat_kernels();
  const SrgbTables& srgb = SrgbTables::get();
  const BlendDepth blend = two_passes                         ? BlendDepth::test
                           : splatting == Splatting::no_depth ? BlendDepth::none
                                                              : BlendDepth::write;
  for_each(executor_, picture_.grid.count(), [&](int number) {
    if (!touches(color_splats_, number) && !(two_passes && touches(*depth_splats, number))) return;
    const auto start = std::chrono::steady_clock::now();
    SplatTile tile;
    tile.pixels = picture_.grid.pixels(number);
    tile.depth.fill(0.0f);
    if (two_passes) {
      for (const SplatBlock& block : depth_splats->blocks())
        if (touches(block, number)) kernels.depth(block, number, view, tile);
    }
    first_pass += (std::chrono::steady_clock::now() - start).count();
    for (TilePlane* plane : {&tile.red, &tile.green, &tile.blue, &tile.weight}) plane->fill(0.0f);
    if (late != nullptr)
      for (TilePlane* plane : {&tile.normal_x, &tile.normal_y, &tile.normal_z}) plane->fill(0.0f);
    if (!means)
      each_pixel(tile, picture_, [&](std::size_t pixel, std::size_t at) {
        const glm::vec3 color = srgb.decode(picture_.colors[pixel]);
        tile.red[at] = color.r;
        tile.green[at] = color.g;
        tile.blue[at] = color.b;
      });
    for (const SplatBlock& block : color_splats_.blocks()) {
      if (!touches(block, number)) continue;
      if (late != nullptr)
        kernels.sum_normals(block, number, view, tile);
      else if (means)
        kernels.sum(block, number, view, tile);
      else
        kernels.blend(block, number, view, blend, tile);
    }
    picture_.busy[static_cast<std::size_t>(number)] = 1;
    each_pixel(tile, picture_, [&](std::size_t pixel, std::size_t at) {
      picture_.depths[pixel] = tile.depth[at];
      const float weight = tile.weight[at];
      if (!(weight >= kNoWeight)) return;
      const glm::vec3 color(tile.red[at], tile.green[at], tile.blue[at]);
      if (late != nullptr)
        picture_.normals[pixel] =
            glm::vec3(tile.normal_x[at], tile.normal_y[at], tile.normal_z[at]) / weight;
      picture_.colors[pixel] =
          means ? srgb.encode(color / weight, kDrawn)
                : srgb.encode(color,
                              static_cast<std::uint8_t>(255.0f * std::min(weight, 1.0f) + 0.5f));
    });
    both_passes += (std::chrono::steady_clock::now() - start).count();
  });
  const double splatting_ms = laps.lap();
  const double share =
      static_cast<double>(first_pass) / static_cast<double>(std::max<std::int64_t>(both_passes, 1));
  stages_.visibility = share * splatting_ms;
  stages_.shading = (1.0 - share) * splatting_ms;

  close_surface(view, late, options);
}

void SoftwareRenderer::close_surface(const PictureView& view, const ShadingView* late,
                                     const DrawOptions& options) {
  const bool fills = options.fill_holes && (options.mode == DrawMode::strip ||
                                            options.splatting == Splatting::normalized);
  const InstanceBounds& bounds = instances_.bounds();
  Laps laps;
  if (fills && instances_.normals_estimated()) {
    HoleFilling::clear_see_through(view, static_cast<float>(bounds.mean_radius()),
                                   nearest_depth(bounds, view.to_clip, view.eye.w), executor_,
                                   picture_);
  }
  if (late != nullptr) {
    stages_.reconstruction += laps.lap();
    light(view, *late, options);
    laps.lap();
  }
  if (fills)
    holes_.find(picture_, radius_in_pixels(bounds, view.to_clip, picture_.grid.size), executor_);
  // What is filled has no depth of its own, and is not darkened.
  if (options.edl > 0.0f) light_eye_dome(options.edl, executor_, picture_);
  if (fills) holes_.fill(executor_, picture_);
  stages_.reconstruction += laps.lap();
}

void SoftwareRenderer::present(unsigned framebuffer) {
  // Where it is enlarged, the filter reads the pixel beside each border of what is copied.
  const glm::ivec2 size = picture_.grid.size;
  texture_.upload(picture_, {glm::max(drawn_on_.min - 1, 0), glm::min(drawn_on_.max + 1, size)});
  // The bytes are copied without conversion.
  glDisable(GL_FRAMEBUFFER_SRGB);
  glDisable(GL_SCISSOR_TEST);
  const std::array<GLfloat, 4> background = {background_.x, background_.y, background_.z, 1.0f};
  glClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, background.data());
  if (drawn_on_.empty()) return;
  const auto [from, to] = drawn_on_;
  const glm::ivec2 shown_from = from * shown_ / size, shown_to = to * shown_ / size;
  glBlitNamedFramebuffer(texture_.framebuffer(), framebuffer, from.x, from.y, to.x, to.y,
                         shown_from.x, shown_from.y, shown_to.x, shown_to.y, GL_COLOR_BUFFER_BIT,
                         size == shown_ ? GL_NEAREST : GL_LINEAR);
}

unsigned SoftwareRenderer::texture() {
  if (picture_.grid.size.x == 0) return 0;
  texture_.upload(picture_, {glm::ivec2(0), picture_.grid.size});
  return texture_.name();
}

std::optional<glm::dvec3> SoftwareRenderer::point_at(const glm::dvec2& pixel) const {
  const glm::ivec2 size = picture_.grid.size;
  if (size.x == 0) return std::nullopt;
  // In pixels of the drawn picture, from the lower left corner.
  const glm::dvec2 at =
      glm::dvec2(pixel.x, shown_.y - pixel.y) * glm::dvec2(size) / glm::dvec2(shown_);
  const PixelRect area = pick_area(at, size);
  if (area.empty()) return std::nullopt;
  std::vector<float> depths;
  for (int y = area.min.y; y < area.max.y; ++y)
    for (int x = area.min.x; x < area.max.x; ++x)
      depths.push_back(picture_.depths[picture_.index(x, y)]);
  return pick(at, area, depths, camera_, size);
}

Result<Image> SoftwareRenderer::read_pixels() const {
  const glm::ivec2 size = picture_.grid.size;
  if (size.x == 0) return fail(ErrorCode::not_found, "there is no picture yet");
  Image image{size.x, size.y, {}};
  image.pixels.reserve(picture_.colors.size());
  for (int y = size.y; y-- > 0;)
    for (int x = 0; x < size.x; ++x)
      image.pixels.emplace_back(picture_.colors[picture_.index(x, y)]);
  return image;
}

}  // namespace pointreel
