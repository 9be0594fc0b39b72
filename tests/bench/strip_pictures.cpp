#include "tests/bench/strip_pictures.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/prepare/strip_frame.h"
#include "client/render/opengl/gl_context.h"
#include "client/render/opengl/gl_renderer.h"
#include "common/base/try.h"
#include "common/process/print.h"
#include "common/threads/tbb_executor.h"
#include "datasets_synthetic/sequences.h"
#include "tests/bench/render/quality.h"
#include "tests/bench/render/scenes.h"
#include "tests/bench/render/viewpoints.h"

namespace pointreel::bench {
namespace {

constexpr glm::ivec2 kSize{1280, 720};

struct Way {
  std::string name;
  DrawOptions options;
};

/// Ways to draw the same surfels. Holes are left, so that it is seen what each of them covers.
std::vector<Way> ways_to_draw() {
  return {
      {"strips", {.mode = DrawMode::strip, .fill_holes = false}},
      {"surfels", {.fill_holes = false}},
      {"two-pass splats",
       {.instancing = Instancing::uniform, .splatting = Splatting::two_pass, .fill_holes = false}}};
}

Result<void> measure_scene(const SceneChoice& choice, Renderer& renderer, nlohmann::json& rows) {
  const RenderScene scene = TRY(make_render_scene(choice));
  auto stripped = std::make_shared<SceneFrame>(*scene.surfels);
  make_strips(*stripped, tbb_executor());
  const std::shared_ptr<const SceneFrame> strips = std::move(stripped);
  const std::vector<Viewpoint> views = viewpoints(scene.truth, kSize);
  for (const std::size_t number : {std::size_t{0}, views.size() - 1}) {
    const ViewTruth view = make_view_truth(scene, views[number], kSize);
    for (const Way& way : ways_to_draw()) {
      const auto& frame = way.options.mode == DrawMode::strip ? strips : scene.surfels;
      const DrawnPicture picture =
          TRY(draw_picture(renderer, frame, view.view.camera, kSize, way.options));
      nlohmann::json row = {{"scene", choice.name},
                            {"surfels", frame->cloud.size()},
                            {"view", view.view.name},
                            {"drawn_as", way.name},
                            {"errors", picture_errors(view.truth, picture)}};
      const nlohmann::json& errors = row["errors"];
      print("{:<28} {:>8} {:<10} {:<16} {:>8.2f} {:>8.4f} {:>8.2f} {:>8.2f} {:>8.4f}\n",
            choice.name, frame->cloud.size(), view.view.name, way.name,
            errors["psnr_mask"].get<double>(), errors["ssim_mask"].get<double>(),
            100.0 * errors["holes"].get<double>(), 100.0 * errors["dilation"].get<double>(),
            errors["iou"].get<double>());
      rows.push_back(std::move(row));
    }
  }
  return {};
}

}  // namespace

Result<nlohmann::json> measure_strip_pictures() {
  const Motion* motion = find_motion("soccer-shoot");
  const OffscreenContext context = TRY(OffscreenContext::create());
  GlRenderer renderer = TRY(GlRenderer::create());
  auto rows = nlohmann::json::array();
  print("\n{:<28} {:>8} {:<10} {:<16} {:>8} {:>8} {:>8} {:>8} {:>8}\n", "against the surface",
        "surfels", "view", "drawn as", "PSNR", "SSIM", "holes, %", "more, %", "IoU");
  const std::vector<SceneChoice> choices = {
      {.name = "soccer-shoot, as scanned", .motion = motion, .pose = 0, .even_points = 0},
      {.name = "even", .motion = motion, .pose = 0, .even_points = 10'000},
      {.name = "even", .motion = motion, .pose = 0, .even_points = 60'000},
  };
  for (const SceneChoice& choice : choices) TRY(measure_scene(choice, renderer, rows));
  return rows;
}

}  // namespace pointreel::bench
