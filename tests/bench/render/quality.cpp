#include "tests/bench/render/quality.h"

#include <algorithm>
#include <cstdlib>
#include <optional>

#include <fmt/format.h>

#include "common/base/try.h"
#include "tests/read_alpha.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

/// A point this far behind the visible surface, in metres, belongs to another surface. It is more
/// than noise and the thickness of a splat, and less than the distance to the back of a limb.
constexpr double kHiddenBehind = 0.015;

/// In a picture of white and black points, a covered pixel below this value bleeds: 5 % of its
/// light does not come from the surface that is visible there.
constexpr std::uint8_t kWhite = 249;

json number(std::optional<double> value) { return value ? json(*value) : json(nullptr); }

/// The share of the pixels covered in both to which another surface or the background contributes.
double bleed(const DrawnPicture& picture, const Mask& mask) {
  std::size_t covered = 0, mixed = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (!mask[i] || !picture.covered[i]) continue;
    ++covered;
    mixed += picture.image.pixels[i].x < kWhite;
  }
  return covered > 0 ? static_cast<double>(mixed) / static_cast<double>(covered) : 0.0;
}

}  // namespace

std::vector<PictureSetting> picture_settings() {
  std::vector<PictureSetting> settings = {{"default", {}}};
  for (const Splatting splatting : {Splatting::regular, Splatting::no_depth, Splatting::two_pass,
                                    Splatting::enlarged, Splatting::enlarged_shading}) {
    // Not Instancing::pull, which draws no splat smaller than a pixel.
    settings.push_back(
        {name(splatting), {.instancing = Instancing::uniform, .splatting = splatting}, true});
  }
  settings.push_back({"default, holes left", {.fill_holes = false}});
  settings.push_back({"default, not pulled", {.instancing = Instancing::uniform}});
  for (const SplatScales& scales : {SplatScales{1.0f, 1.0f}, SplatScales{1.0f, 2.0f},
                                    SplatScales{1.5f, 2.0f}, SplatScales{2.0f, 2.0f}}) {
    settings.push_back(
        {fmt::format("normalized {}, {}", scales.visibility, scales.shading), {.scales = scales}});
  }
  settings.push_back({"voxels", {.mode = DrawMode::voxel}});
  settings.push_back({"points", {.mode = DrawMode::point}});
  settings.push_back(
      {"points of a fixed size", {.mode = DrawMode::point, .adaptive_points = false}});
  return settings;
}

const std::shared_ptr<const SceneFrame>& frame_of(const RenderScene& scene, DrawMode mode) {
  return mode == DrawMode::voxel ? scene.voxels : scene.surfels;
}

Result<DrawnPicture> draw_picture(Renderer& renderer, std::shared_ptr<const SceneFrame> frame,
                                  const Camera& camera, glm::ivec2 size,
                                  const DrawOptions& options) {
  const DrawStats stats = TRY(renderer.draw(std::move(frame), camera, size, options));
  Image image = TRY(renderer.read_pixels());
  return DrawnPicture{std::move(image), read_alpha(renderer), stats};
}

json picture_errors(const TruthPicture& truth, const DrawnPicture& picture) {
  const Similarity similarity(truth.image, picture.image);
  const Coverage coverage = compare_coverage(truth.mask, picture.covered);
  return {{"psnr_mask", number(psnr(truth.image, picture.image, truth.mask))},
          {"psnr", number(psnr(truth.image, picture.image))},
          {"ssim_mask", similarity.mean(truth.mask)},
          {"ssim", similarity.mean()},
          {"holes", coverage.holes},
          {"dilation", coverage.dilation},
          {"iou", coverage.iou}};
}

ViewTruth make_view_truth(const RenderScene& scene, const Viewpoint& view, glm::ivec2 size) {
  TruthStyle style;
  style.texture = scene.surfels->cloud.has_colors();
  return {view, cast_truth(scene.truth, view.camera, size, style),
          labelled(*scene.surfels, scene.truth, view.camera, kHiddenBehind)};
}

Result<Quality> measure_quality(Renderer& renderer, const RenderScene& scene, const ViewTruth& view,
                                const PictureSetting& setting, bool whole) {
  const TruthPicture& truth = view.truth;
  const glm::ivec2 size(truth.image.width, truth.image.height);
  DrawOptions options = setting.options;
  if (!scene.surfels->cloud.has_colors()) options.color = ColorSource::normals;  // as in the truth
  const bool voxels = options.mode == DrawMode::voxel;
  const auto& frame = frame_of(scene, options.mode);
  const auto draw = [&](const std::shared_ptr<const SceneFrame>& what, const DrawOptions& how) {
    return draw_picture(renderer, what, view.view.camera, size, how);
  };
  DrawnPicture picture = TRY(draw(frame, options));

  json row = {
      {"setting", setting.name}, {"papers", setting.papers}, {"drawn", picture.stats.drawn}};
  row.update(picture_errors(truth, picture));

  // The order of voxels does not depend on that of the points, and labels would mix in their
  // colours.
  if (!voxels && whole) {
    DrawOptions plain = options;
    plain.lighting = false;
    plain.background = glm::vec3(0.0f);
    row["bleed"] = bleed(TRY(draw(view.labelled, plain)), truth.mask);
  }
  if (!voxels && whole) {
    const DrawnPicture first = TRY(draw(shuffled(*frame, 1), options));
    const DrawnPicture second = TRY(draw(shuffled(*frame, 2), options));
    const Difference apart = difference(first.image, second.image);
    row["order"] = {{"rms", apart.rms}, {"largest", apart.largest}};
  }
  if (whole) {  // after other frames, so that nothing is reused
    const DrawnPicture again = TRY(draw(frame, options));
    row["flicker"] = difference(picture.image, again.image).largest;
  }
  return Quality{std::move(row), std::move(picture.image)};
}

Image side_by_side(const Image& truth, const Image& picture) {
  const int width = truth.width / 2, height = truth.height / 2;
  Image out{3 * width, height, {}};
  out.pixels.resize(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(height));
  const auto shrunk = [&](int x, int y, const auto& value) {
    glm::ivec3 sum(2);
    for (int dy = 0; dy < 2; ++dy) {
      for (int dx = 0; dx < 2; ++dx) sum += value(2 * x + dx, 2 * y + dy);
    }
    return glm::u8vec3(sum / 4);
  };
  const auto of = [](const Image& image) {
    return [&image](int x, int y) { return glm::ivec3(image.at(x, y)); };
  };
  const auto apart = [&](int x, int y) {
    const glm::ivec3 d = glm::ivec3(truth.at(x, y)) - glm::ivec3(picture.at(x, y));
    return glm::min(4 * glm::abs(d), glm::ivec3(255));
  };
  for (int y = 0; y < height; ++y) {
    glm::u8vec3* row = out.pixels.data() + static_cast<std::ptrdiff_t>(y) * out.width;
    for (int x = 0; x < width; ++x) {
      row[x] = shrunk(x, y, of(truth));
      row[width + x] = shrunk(x, y, of(picture));
      row[2 * width + x] = shrunk(x, y, apart);
    }
  }
  return out;
}

}  // namespace pointreel::bench
