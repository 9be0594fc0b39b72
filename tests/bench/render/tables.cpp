#include "tests/bench/render/tables.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/base/try.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

constexpr double kPaperDelta = 0.05;
constexpr int kTraversalDepth = 10;

/// Milliseconds from Tables II and IV of Slomp et al., Geometry Instancing, for geometry shader,
/// uniform, texture and vertex buffers, and the depth from Table IV.
struct Paper {
  std::string_view motion;
  std::array<double, 4> surfels, voxels;
  int depth;
};
constexpr std::array<Paper, 5> kPaper = {{
    {"baseball", {4.518, 7.461, 7.873, 13.11}, {3.594, 2.639, 2.784, 5.788}, 10},
    {"basketball", {3.673, 6.387, 6.782, 12.15}, {3.454, 2.549, 2.773, 5.599}, 10},
    {"kick", {5.177, 8.218, 8.933, 14.96}, {3.914, 2.831, 3.167, 6.229}, 11},
    {"soccer-juggle", {4.921, 7.843, 8.236, 14.40}, {3.763, 2.742, 2.961, 6.083}, 10},
    {"soccer-shoot", {3.323, 5.397, 5.658, 9.099}, {2.466, 1.835, 1.927, 4.071}, 10},
}};

constexpr auto& kMethods = kEnumNames<Instancing>;

/// Times and picture errors of a frame drawn by every method, and with the default.
Result<json> measure_methods(Renderer& renderer, const std::shared_ptr<const SceneFrame>& frame,
                             std::span<const ViewTruth* const> views, const DrawOptions& papers,
                             const DrawOptions& usual, int runs, Stopwatch stopwatch) {
  std::vector<TimedDraw> draws;
  for (const auto& method : kMethods) {
    draws.push_back({frame, papers});
    draws.back().options.instancing = method.value;
  }
  draws.push_back({frame, usual});

  std::vector<Camera> cameras;
  const Image& first = views[0]->truth.image;
  const glm::ivec2 size(first.width, first.height);
  std::vector<double> psnrs(draws.size()), holes(draws.size());
  double differ = 0.0;
  for (const ViewTruth* view : views) {
    cameras.push_back(view->view.camera);
    std::optional<Image> one;
    for (std::size_t i = 0; i < draws.size(); ++i) {
      const DrawnPicture picture =
          TRY(draw_picture(renderer, frame, view->view.camera, size, draws[i].options));
      const TruthPicture& truth = view->truth;
      psnrs[i] += psnr(truth.image, picture.image, truth.mask).value_or(99.0);
      holes[i] += compare_coverage(truth.mask, picture.covered).holes;
      if (i == kMethods.size()) break;
      if (one) differ = std::max(differ, difference(*one, picture.image).share);
      if (!one) one = picture.image;
    }
  }
  const auto timings = TRY(time_in_turns(renderer, draws, cameras, size, runs, stopwatch));
  const auto row = [&](std::size_t i) {
    const auto count = static_cast<double>(views.size());
    return json{
        {"ms", to_json(timings[i])}, {"psnr_mask", psnrs[i] / count}, {"holes", holes[i] / count}};
  };
  json methods = json::object();
  for (std::size_t i = 0; i < kMethods.size(); ++i) methods[kMethods[i].name] = row(i);
  return json{{"methods", methods}, {"default", row(kMethods.size())}, {"differ", differ}};
}

}  // namespace

Result<json> measure_tables(Renderer& renderer, const RenderScene& scene,
                            std::span<const ViewTruth> all_views, int runs, Stopwatch stopwatch) {
  const std::array views = {&all_views.front(), &all_views.back()};
  DrawOptions papers;
  papers.splatting = Splatting::enlarged_shading;
  json surfels = TRY(measure_methods(renderer, scene.surfels, views, papers, {}, runs, stopwatch));

  const auto divided = TRY(prepare_cloud(scene.surfels->cloud, DrawMode::voxel, kPaperDelta));
  DrawOptions usual;
  usual.mode = DrawMode::voxel;
  papers = usual;
  papers.voxel_shape = VoxelShape::cube;
  json voxels = TRY(measure_methods(renderer, divided, views, papers, usual, runs, stopwatch));
  voxels["depth"] = divided->svo.depth;

  for (const Paper& paper : kPaper) {
    if (paper.motion != scene.choice.motion->name) continue;
    surfels["paper"] = json::object();
    voxels["paper"] = {{"depth", paper.depth}};
    for (std::size_t i = 0; i < paper.surfels.size(); ++i) {
      surfels["paper"][kMethods[i].name] = paper.surfels[i];
      voxels["paper"][kMethods[i].name] = paper.voxels[i];
    }
  }
  const Image& picture = views[0]->truth.image;
  const Timing traversal = time_traversal(scene.surfels->cloud, kTraversalDepth,
                                          {picture.width, picture.height}, std::max(runs, 25));
  return json{{"surfels", surfels}, {"voxels", voxels}, {"traverse_ms", to_json(traversal)}};
}

}  // namespace pointreel::bench
