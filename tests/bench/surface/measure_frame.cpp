#include "tests/bench/surface/measure_frame.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include <tbb/parallel_for.h>

#include "client/prepare/prepare.h"
#include "codec/draco/part_sizes.h"
#include "codec/package/grid.h"
#include "common/base/try.h"
#include "datasets_synthetic/closest_point.h"
#include "tests/bench/measure.h"
#include "tests/bench/render/quality.h"
#include "tests/bench/surface/true_surface.h"

namespace pointreel::bench {
namespace {

Result<Grid> grid_of(const PointCloud& cloud, const Treatment& treatment,
                     const CleanReport& report) {
  EncodingOptions options;
  if (treatment.depth) {
    std::get<OctreeOptions>(options.encode.codec).depth = DepthRule::fixed(*treatment.depth);
  }
  std::optional<PointLattice> lattice;
  if (report.cleaned && cells_follow_points(options)) lattice = lattice_for_cells(report.cell);
  return grid_for(bounds(cloud), options, lattice);
}

/// At least this share of the values is not larger.
double percentile_95(std::vector<double> values) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 95 / 100);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// The angle in degrees between each normal and that of the surface there.
std::vector<double> normal_errors(const Surface& surface, const PointCloud& cloud) {
  std::vector<double> degrees(cloud.size());
  tbb::parallel_for(std::size_t{0}, cloud.size(), [&](std::size_t i) {
    const glm::dvec3 gradient = distance_to(surface, cloud.world(i)).distance.gradient;
    const double cosine = glm::dot(glm::normalize(gradient), glm::dvec3(cloud.normals[i]));
    degrees[i] = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / std::numbers::pi;
  });
  return degrees;
}

void compare_with_truth(const TruthScene& scene, const PointCloud& cloud, SurfaceFigures& figures) {
  const std::vector<double> distances = true_distances(scene.grid, cloud);
  const double squares =
      std::inner_product(distances.begin(), distances.end(), distances.begin(), 0.0);
  figures.distance_rms_mm = 1000.0 * std::sqrt(squares / static_cast<double>(cloud.size()));
  figures.distance_p95_mm = 1000.0 * percentile_95(distances);
  const std::vector<double> degrees = normal_errors(scene.body.surface, cloud);
  figures.normal_mean_degrees = mean_of(degrees);
  figures.normal_p95_degrees = percentile_95(degrees);
}

/// The frame as it comes from a package.
FetchedFrame fetched(const EncodedFrame& frame) {
  FetchedFrame out;
  for (const Chunks<Bytes>& layer : frame.layers) {
    Bytes bytes;
    for (const Bytes* chunk : {&layer.geometry, &layer.colors, &layer.normals}) {
      bytes.insert(bytes.end(), chunk->begin(), chunk->end());
    }
    const auto size = [](const Bytes& chunk) { return static_cast<std::uint32_t>(chunk.size()); };
    out.layers.push_back(
        {std::move(bytes), {size(layer.geometry), size(layer.colors), size(layer.normals)}});
  }
  return out;
}

Result<void> measure_pictures(Renderer& renderer, const TrueFrame& frame,
                              const std::shared_ptr<const SceneFrame>& scene,
                              SurfaceFigures& figures) {
  std::vector<double> psnr, ssim, holes, iou;
  for (const auto& [camera, truth] : frame.views) {
    const glm::ivec2 size(truth.image.width, truth.image.height);
    const DrawnPicture picture = TRY(draw_picture(renderer, scene, camera, size, {}));
    const nlohmann::json errors = picture_errors(truth, picture);
    psnr.push_back(errors["psnr_mask"].get<double>());
    ssim.push_back(errors["ssim_mask"].get<double>());
    holes.push_back(errors["holes"].get<double>());
    iou.push_back(errors["iou"].get<double>());
  }
  figures.psnr = mean_of(psnr);
  figures.ssim = mean_of(ssim);
  figures.holes = mean_of(holes);
  figures.iou = mean_of(iou);
  return {};
}

/// The scene that a player makes of a treated frame.
Result<SceneFrame> scene_of(const EncodedFrame& encoded, const Treatment& treatment) {
  SceneFrame scene = TRY(prepare_frame(fetched(encoded), {}, {}));
  if (!settles(treatment)) scene.heights.clear();
  return scene;
}

/// How far apart the surfels of two frames are that were treated one by one.
Result<double> measure_movement(const TrueFrame& frame, const Treatment& treatment) {
  std::vector<PointCloud> surfels;
  std::optional<Grid> grid;
  for (const FrameInTime& source : frame.still) {
    const Treated treated = treat(source, *frame.still_body, treatment, frame.automatic, 1);
    if (!grid) grid = TRY(grid_of(treated.cloud, treatment, treated.report));
    const EncodedFrame encoded = TRY(encode_frame(treated.cloud, grid->cube, grid->encode));
    surfels.push_back(surfels_of(TRY(scene_of(encoded, treatment))));
  }
  return 1000.0 * movement_of_surface(*frame.still_body, surfels[0], surfels[1]);
}

}  // namespace

Result<SceneFrame> treated_scene(const TrueFrame& frame, const Treatment& treatment) {
  const Treated treated = treat(frame.source, frame.scene.body, treatment, frame.automatic, 1);
  const Grid grid = TRY(grid_of(treated.cloud, treatment, treated.report));
  return scene_of(TRY(encode_frame(treated.cloud, grid.cube, grid.encode)), treatment);
}

Result<SurfaceFigures> measure_frame(Renderer& renderer, const TrueFrame& frame,
                                     const Treatment& treatment, int runs) {
  const Treated treated = treat(frame.source, frame.scene.body, treatment, frame.automatic, runs);
  const PointCloud& cloud = treated.cloud;
  const Grid grid = TRY(grid_of(cloud, treatment, treated.report));
  const EncodedFrame encoded = TRY(encode_frame(cloud, grid.cube, grid.encode));
  const std::vector<Chunks<ByteView>> layers = layer_views(encoded.layers);
  const auto scene = std::make_shared<const SceneFrame>(TRY(scene_of(encoded, treatment)));
  const PointCloud surfels = surfels_of(*scene);
  const auto parts = TRY(measure_part_sizes(encoded, cloud, grid.cube, grid.encode));

  SurfaceFigures figures;
  figures.points = static_cast<double>(frame.source.cloud.size());
  figures.surfels = static_cast<double>(surfels.size());
  figures.removed = static_cast<double>(treated.report.removed);
  figures.radius_mm = 1000.0 * treated.report.radius;
  figures.cell_mm = 1000.0 * treated.report.cell;
  const auto bits = [&](std::size_t bytes) {
    return 8.0 * static_cast<double>(bytes) / figures.points;
  };
  figures.geometry_bits = bits(parts.geometry);
  figures.color_bits = bits(parts.colors);
  figures.normal_bits = bits(parts.normals);
  figures.bits = bits(encoded.size());
  figures.surfel_bits = figures.bits * figures.points / figures.surfels;
  figures.clean_ms = treated.milliseconds;
  figures.encode_ms =
      measure(runs, [&] { (void)encode_frame(cloud, grid.cube, grid.encode); }).median;
  figures.decode_ms = measure(runs, [&] { (void)decode_frame(layers); }).median;
  compare_with_truth(frame.scene, surfels, figures);
  if (treatment.pictures) TRY(measure_pictures(renderer, frame, scene, figures));
  if (!frame.still.empty() && measures_movement(treatment))
    figures.movement_rms_mm = TRY(measure_movement(frame, treatment));
  return figures;
}

}  // namespace pointreel::bench
