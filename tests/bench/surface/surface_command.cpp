#include "tests/bench/surface/surface_command.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "client/render/opengl/gl_context.h"
#include "common/base/try.h"
#include "common/process/print.h"
#include "common/process/progress.h"
#include "tests/bench/measure.h"
#include "tests/bench/output.h"
#include "tests/bench/report/datasets.h"
#include "tests/bench/surface/captures.h"
#include "tests/bench/surface/close_views.h"
#include "tests/bench/surface/measure_frame.h"
#include "tests/bench/surface/smoothing_library.h"
#include "tests/bench/surface/surface_bars.h"
#include "tests/bench/surface/surface_markdown.h"
#include "tests/bench/surface/surface_plots.h"

namespace pointreel::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// How much is measured.
struct Effort {
  int poses, views, runs;
  glm::ivec2 size;
};
constexpr Effort kFull = {2, 4, 3, {960, 640}};
constexpr Effort kQuick = {1, 2, 1, {480, 320}};

/// On either side of each frame.
constexpr int kFramesAround = 2;

Result<FrameInTime> frame_in_time(const Capture& capture, const SequenceOptions& options,
                                  int number) {
  FrameInTime frame{TRY(sequence_frame(*capture.motion, options, number)), {}};
  for (int by = 1; by <= kFramesAround; ++by)
    for (const int other : {number - by, number + by})
      if (other >= 0 && (options.still || other < capture.motion->poses))
        frame.around.push_back(
            clean_alone(TRY(sequence_frame(*capture.motion, options, other)), {}));
  return frame;
}

Result<TrueFrame> make_frame(const Capture& capture, int pose, const Effort& effort) {
  TrueFrame frame{
      TRY(frame_in_time(capture, capture.options, pose)),
      {},
      {},
      TRY(make_truth_scene(pose_body(frame_pose(*capture.motion, capture.options, pose)))),
      {},
      {}};
  PointCloud cleaned = frame.source.cloud;
  frame.automatic = clean(cleaned);
  for (const Viewpoint& view : viewpoints(frame.scene, effort.size, effort.views)) {
    frame.views.push_back({view.camera, cast_truth(frame.scene, view.camera, effort.size, {})});
  }
  return frame;
}

json row_of(const Treatment& treatment, const std::vector<SurfaceFigures>& all) {
  json row = to_json(mean(all));
  row["setting"] = name(treatment);
  row["kind"] = name(treatment.kind);
  row["value"] = treatment.value;
  row["depth"] = treatment.depth ? json(*treatment.depth) : json();
  return row;
}

/// All figures of a capture: for each treatment, one for each pose; and those of close views for
/// each pose.
struct Measured {
  std::vector<std::vector<SurfaceFigures>> treatments;
  std::vector<std::vector<CloseView>> close;

  void add(const Measured& other) {
    treatments.resize(other.treatments.size());
    for (std::size_t i = 0; i < treatments.size(); ++i)
      treatments[i].insert(treatments[i].end(), other.treatments[i].begin(),
                           other.treatments[i].end());
    close.insert(close.end(), other.close.begin(), other.close.end());
  }
};

/// Adds the frames of a still scene, which show the first pose.
Result<void> add_still(const Capture& capture, TrueFrame& frame) {
  SequenceOptions options = capture.options;
  options.still = true;
  frame.still_body = pose_body(frame_pose(*capture.motion, options, 0));
  for (const int number : {kFramesAround, kFramesAround + 1}) {
    frame.still.push_back(TRY(frame_in_time(capture, options, number)));
  }
  return {};
}

Result<Measured> measure_capture(Renderer& renderer, const Capture& capture,
                                 const std::vector<Treatment>& treatments, const Effort& effort,
                                 Progress& progress) {
  Measured measured;
  measured.treatments.resize(treatments.size());
  for (const int pose : spread(capture.motion->poses, effort.poses)) {
    TrueFrame frame = TRY(make_frame(capture, pose, effort));
    if (measured.close.empty()) TRY(add_still(capture, frame));
    for (std::size_t i = 0; i < treatments.size(); ++i) {
      auto figures = measure_frame(renderer, frame, treatments[i], effort.runs);
      if (!figures) return fail_at(name(treatments[i]), figures.error());
      measured.treatments[i].push_back(*figures);
      progress.tick();
    }
    measured.close.push_back(TRY(measure_close_views(renderer, frame, effort.runs)));
  }
  return measured;
}

json rows_of(const std::vector<Treatment>& treatments, const Measured& measured) {
  json rows = json::array();
  for (std::size_t i = 0; i < treatments.size(); ++i) {
    rows.push_back(row_of(treatments[i], measured.treatments[i]));
  }
  return rows;
}

Result<json> measure_surface(bool quick) {
  const double begin = now_ms();
  const Effort& effort = quick ? kQuick : kFull;
  const OffscreenContext context = TRY(OffscreenContext::create());
  GlRenderer renderer = TRY(GlRenderer::create());
  const std::vector<Capture> captures = surface_captures(quick);
  const std::vector<Treatment> treatments = surface_treatments(quick);
  const auto library = smoothing_library();
  json report = {{"benchmark", "surface"},
                 {"quick", quick},
                 {"machine", machine()},
                 {"library", library ? json(*library) : json()},
                 {"poses", effort.poses},
                 {"views", effort.views},
                 {"size", {effort.size.x, effort.size.y}},
                 {"captures", json::array()},
                 {"groups", json::array()}};
  report["machine"]["gl_renderer"] = describe_opengl();
  Progress progress("surface",
                    captures.size() * treatments.size() * static_cast<std::size_t>(effort.poses));
  std::vector<std::pair<std::string, Measured>> groups;
  for (const Capture& capture : captures) {
    auto measured = measure_capture(renderer, capture, treatments, effort, progress);
    if (!measured) return fail_at(std::string(capture.motion->name), measured.error());
    report["captures"].push_back({{"sequence", std::string(capture.motion->name)},
                                  {"group", capture.group},
                                  {"rows", rows_of(treatments, *measured)}});
    if (groups.empty() || groups.back().first != capture.group) {
      groups.emplace_back(capture.group, Measured{});
    }
    groups.back().second.add(*measured);
  }
  for (const auto& [group, measured] : groups) {
    report["groups"].push_back({{"group", group},
                                {"rows", rows_of(treatments, measured)},
                                {"close_views", to_json(measured.close)}});
  }
  report["bars"] = to_json(surface_bars(report), quick);
  report["seconds"] = (now_ms() - begin) / 1000.0;
  return report;
}

Result<void> write_surface_report(const fs::path& folder, bool quick) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(ErrorCode::io, folder.string() + ": " + error.message());
  const json report = TRY(measure_surface(quick));
  const std::string text = to_surface_markdown(report);
  TRY(write_text(folder / "surface.json", report.dump(2) + "\n"));
  TRY(write_text(folder / "surface.md", text));
  TRY(draw_surface_plots(folder, report));
  print_lines(text);
  print("Written: {}, and beside it surface.json and the plots\n",
        (folder / "surface.md").string());
  return {};
}

}  // namespace

void add_surface_command(cli::Command app, int& exit_code) {
  struct Options {
    std::string folder = default_folder("surface");
    bool quick = false;
  };
  const cli::Command command = app.add_subcommand(
      "surface", "cleaning noisy sequences: sizes, speeds, and errors against the true surface");
  const auto options = std::make_shared<Options>();
  command.add_option("-o,--output", options->folder, "the folder to write to; created if missing")
      .type_name("DIR")
      .capture_default_str();
  command.add_flag("--quick", options->quick, "two frames and few settings; takes a few minutes");
  command.callback([options, &exit_code] {
    const auto written = write_surface_report(options->folder, options->quick);
    if (written) return;
    print_error("pointreel-bench", written.error().message);
    exit_code = 1;
  });
}

}  // namespace pointreel::bench
