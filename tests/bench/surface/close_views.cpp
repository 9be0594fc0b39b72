#include "tests/bench/surface/close_views.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "client/scene/refinement.h"
#include "common/base/try.h"
#include "tests/bench/measure.h"
#include "tests/bench/output.h"
#include "tests/bench/render/quality.h"
#include "tests/bench/table.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

constexpr glm::ivec2 kSize{1280, 720};
constexpr double kDistance = 0.5;
/// From the joint of the head to the middle of the face, along the head.
constexpr double kUp = 0.08;
constexpr double kTurn = 0.02;

Camera camera_before(const Body& body) {
  const Frame& head = body.frames[static_cast<std::size_t>(Bone::head)];
  const glm::dvec3 ahead = head.axes[2];
  Camera camera;
  camera.target = head.joint + kUp * head.axes[1];
  camera.distance = kDistance;
  camera.yaw = std::atan2(ahead.x, ahead.z);
  return camera;
}

constexpr std::pair<const char*, double CloseView::*> kFigures[] = {
    {"surfels", &CloseView::surfels},
    {"first_ms", &CloseView::first_ms},
    {"again_ms", &CloseView::again_ms},
    {"psnr", &CloseView::psnr},
    {"ssim", &CloseView::ssim},
    {"holes", &CloseView::holes},
    {"iou", &CloseView::iou}};

}  // namespace

Result<std::vector<CloseView>> measure_close_views(Renderer& renderer, const TrueFrame& frame,
                                                   int runs) {
  const auto scene = std::make_shared<const SceneFrame>(
      TRY(treated_scene(frame, {.kind = Treatment::Kind::automatic})));
  const Camera camera = camera_before(frame.scene.body);
  const TruthPicture truth = cast_truth(frame.scene, camera, kSize, {});
  std::vector<CloseView> views = {
      {"surfels as they are"}, {"divided"}, {"divided, smooth outlines"}};
  double first = std::numeric_limits<double>::infinity(), again = first, surfels = 0.0;
  for (int run = 0; run < runs; ++run) {
    Refinement refinement;
    Camera turned = camera;
    const auto time = [&] {
      const double begin = now_ms();
      refinement.run(scene, turned, kSize);
      return now_ms() - begin;
    };
    first = std::min(first, time());
    surfels = static_cast<double>(refinement.surfels().size());
    turned.orbit(kTurn, 0.0);
    again = std::min(again, time());
  }
  for (std::size_t i = 0; i < views.size(); ++i) {
    CloseView& view = views[i];
    DrawOptions options;
    options.refine = i > 0;
    options.smooth_outlines = i > 1;
    const DrawnPicture picture = TRY(draw_picture(renderer, scene, camera, kSize, options));
    const json errors = picture_errors(truth, picture);
    view.psnr = errors["psnr_mask"].get<double>();
    view.ssim = errors["ssim_mask"].get<double>();
    view.holes = errors["holes"].get<double>();
    view.iou = errors["iou"].get<double>();
    if (!options.refine) continue;
    view.surfels = surfels;
    view.first_ms = first;
    view.again_ms = again;
  }
  return views;
}

json to_json(const std::vector<std::vector<CloseView>>& all) {
  json rows = json::array();
  for (std::size_t i = 0; i < all.front().size(); ++i) {
    json row = {{"setting", all.front()[i].setting}};
    for (const auto& [key, member] : kFigures) {
      double sum = 0.0;
      for (const std::vector<CloseView>& views : all) sum += views[i].*member;
      row[key] = sum / static_cast<double>(all.size());
    }
    rows.push_back(row);
  }
  return rows;
}

std::string close_views_table(const json& rows) {
  Table table({"head from 50 cm", "new surfels", "first picture, ms", "camera moved, ms",
               "PSNR, dB", "SSIM", "holes", "IoU"});
  for (const json& row : rows) {
    const auto number = [&](const char* key, int digits, double factor = 1.0) {
      return fmt::format("{:.{}f}", factor * row[key].get<double>(), digits);
    };
    const bool divides = row["surfels"] > 0.0;
    table.row({row["setting"],
               divides ? grouped(static_cast<std::size_t>(row["surfels"].get<double>())) : "",
               divides ? number("first_ms", 0) : "", divides ? number("again_ms", 0) : "",
               number("psnr", 2), number("ssim", 3), number("holes", 2, 100.0) + " %",
               number("iou", 3)});
  }
  return table.text();
}

}  // namespace pointreel::bench
