#include "tests/bench/render/render_command.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "client/render/opengl/gl_context.h"
#include "common/base/try.h"
#include "common/process/print.h"
#include "common/process/progress.h"
#include "tests/bench/measure.h"
#include "tests/bench/output.h"
#include "tests/bench/render/playback.h"
#include "tests/bench/render/quality.h"
#include "tests/bench/render/render_bars.h"
#include "tests/bench/render/render_markdown.h"
#include "tests/bench/render/sampling_limit.h"
#include "tests/bench/render/software.h"
#include "tests/bench/render/tables.h"

namespace pointreel::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Options {
  std::string folder = default_folder("render");
  std::string json;
  std::vector<std::string> scenes;
  int poses = 1;
  bool quick = false;
  bool gpu = false;
  bool only_software = false;
};

/// How much is measured.
struct Effort {
  glm::ivec2 size;
  int views;
  std::size_t even_points;
  int runs;
  int played_frames;
};
const Effort kFull = {{1920, 1280}, 4, 500'000, 5, 60};
const Effort kQuick = {{480, 320}, 2, 50'000, 1, 4};
/// On a graphics card, the dense scenes have as many points as the bar demands (render_bars.h).
constexpr std::size_t kGpuEvenPoints = 1'000'000;

/// "kick, dense" as "kick-dense".
std::string file_name(const std::string& name) {
  std::string out;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c))) {
      out += c;
    } else if (!out.empty() && out.back() != '-') {
      out += '-';
    }
  }
  return out;
}

/// Measures the quality of every setting in every view, and writes pictures.
Result<json> measure_views(Renderer& renderer, const RenderScene& scene,
                           const std::vector<ViewTruth>& views,
                           const std::vector<PictureSetting>& settings, const fs::path& folder,
                           Progress& progress) {
  json out = json::array();
  for (const ViewTruth& view : views) {
    json rows = json::array();
    for (const PictureSetting& setting : settings) {
      const Quality quality = TRY(measure_quality(renderer, scene, view, setting, out.empty()));
      rows.push_back(quality.row);
      // Pictures of the default from all views, of the others only from the first.
      if (out.empty() || rows.size() == 1) {
        const std::string file = fmt::format("{}_{}_{}.png", file_name(scene.choice.name),
                                             file_name(view.view.name), file_name(setting.name));
        TRY(write_png((folder / file).string(), side_by_side(view.truth.image, quality.image)));
        rows.back()["picture"] = file;
      }
      progress.tick();
    }
    json limit;
    if (scene.choice.even_points > 0) {
      if (const auto psnr = sampling_limit(scene, view)) limit = *psnr;
    }
    out.push_back({{"view", view.view.name},
                   {"coverage", compare_coverage(view.truth.mask, view.truth.mask).truth},
                   {"distance", view.view.camera.distance},
                   {"sampling_limit", limit},
                   {"rows", rows}});
  }
  return out;
}

Result<json> measure_scene(Renderer& renderer, const SceneChoice& choice, const Effort& effort,
                           Stopwatch stopwatch, const fs::path& folder, Progress& progress) {
  const RenderScene scene = TRY(make_render_scene(choice));
  std::vector<ViewTruth> views;
  for (const Viewpoint& viewpoint : viewpoints(scene.truth, effort.size, effort.views)) {
    views.push_back(make_view_truth(scene, viewpoint, effort.size));
  }
  const std::vector<PictureSetting> settings = picture_settings();
  json measured = TRY(measure_views(renderer, scene, views, settings, folder, progress));

  std::vector<TimedDraw> draws;
  for (const PictureSetting& setting : settings) {
    draws.push_back({frame_of(scene, setting.options.mode), setting.options});
  }
  const auto timings = TRY(time_in_turns(renderer, draws, {&views[0].view.camera, 1}, effort.size,
                                         effort.runs, stopwatch));
  for (std::size_t i = 0; i < settings.size(); ++i) {
    measured[0]["rows"][i]["ms"] = to_json(timings[i]);
  }
  json out = {{"scene", choice.name},
              {"motion", choice.motion->name},
              {"pose", choice.pose},
              {"dense", choice.even_points > 0},
              {"points", scene.surfels->cloud.size()},
              {"area", scene.area},
              {"spacing", scene.spacing},
              {"views", measured}};
  if (choice.even_points == 0) {
    out["tables"] = TRY(measure_tables(renderer, scene, views, effort.runs, stopwatch));
  }
  progress.tick();
  return out;
}

/// The scenes of the options: those that they name; else all, or with --quick one of each kind.
Result<std::vector<SceneChoice>> choose_scenes(const Options& options, std::size_t even_points) {
  std::vector<SceneChoice> choices = scene_choices(options.poses, even_points);
  std::vector<std::string> names = options.scenes;
  if (names.empty() && options.quick) names = {"soccer-shoot", "kick, dense"};
  if (names.empty()) return choices;
  std::vector<SceneChoice> chosen;
  for (const std::string& name : names) {
    const auto found =
        std::find_if(choices.begin(), choices.end(),
                     [&name](const SceneChoice& choice) { return choice.name == name; });
    if (found == choices.end()) {
      return fail(ErrorCode::not_found, "there is no scene \"" + name + "\", but for example \"" +
                                            choices.front().name + "\"");
    }
    chosen.push_back(*found);
  }
  return chosen;
}

Result<json> write_render_report(const Options& options) {
  const double begin = now_ms();
  const Effort& effort = options.quick ? kQuick : kFull;
  const fs::path folder = options.folder;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(ErrorCode::io, folder.string() + ": " + error.message());

  const OffscreenContext context = TRY(OffscreenContext::create());
  const std::string gl = describe_opengl();
  const bool software = gl.find("llvmpipe") != std::string::npos;
  if (options.gpu && software) {
    return fail(ErrorCode::unsupported, "--gpu asks for a graphics card, but this is " + gl);
  }
  if (options.json != "-") print("{}\n", gl);
  const auto choices = TRY(choose_scenes(options, software ? effort.even_points : kGpuEvenPoints));
  GlRenderer renderer = TRY(GlRenderer::create());

  json report = {{"benchmark", "render"}, {"quick", options.quick},
                 {"machine", machine()},  {"size", {effort.size.x, effort.size.y}},
                 {"runs", effort.runs},   {"scenes", json::array()}};
  report["machine"]["gl_renderer"] = gl;
  const Stopwatch stopwatch = software ? Stopwatch::wall : Stopwatch::gpu;
  report["stopwatch"] = software ? "wall" : "gpu";
  const std::size_t pictures = static_cast<std::size_t>(effort.views) * picture_settings().size();
  Progress progress("render", choices.size() * (pictures + 1));
  for (const SceneChoice& choice : options.only_software ? std::vector<SceneChoice>{} : choices) {
    auto scene = measure_scene(renderer, choice, effort, stopwatch, folder, progress);
    if (!scene) return fail_at(choice.name, scene.error());
    report["scenes"].push_back(std::move(*scene));
  }
  if (options.scenes.empty() && !options.gpu)
    report["software"] = TRY(measure_software(renderer, folder, options.quick));
  if (options.scenes.empty() && !options.only_software) {
    report["playback"] = TRY(measure_playback(folder, effort.played_frames));
  }
  report["bars"] = to_json(render_bars(report), options.quick);
  report["seconds"] = (now_ms() - begin) / 1000.0;
  return report;
}

Result<void> write_files(const Options& options, const json& report) {
  const fs::path folder = options.folder;
  const std::string text = to_render_markdown(report);
  const std::string name = options.only_software ? "software" : "report";
  TRY(write_text(folder / (name + ".md"), text));
  TRY(write_text(folder / (name + ".json"), report.dump(2) + "\n"));
  if (options.json != "-") {
    print_lines(text);
    print("Written: {0}.md, and beside it {1}.json and the pictures\n", (folder / name).string(),
          name);
  }
  return options.json.empty() ? Result<void>{} : write_json(options.json, report);
}

}  // namespace

void add_render_command(cli::Command app, int& exit_code) {
  const cli::Command command = app.add_subcommand(
      "render", "compares pictures of every mode with the true surface, and times them");
  const auto options = std::make_shared<Options>();
  command.add_option("-o,--output", options->folder, "folder to write to, created if it is missing")
      .capture_default_str();
  command.add_option("--scene", options->scenes, "only this scene; may be repeated");
  command
      .add_option("--poses", options->poses,
                  "number of poses of each scanned sequence, evenly spread")
      .check(cli::range(1, 1000))
      .capture_default_str();
  command.add_flag("--quick", options->quick, "two small scenes and few runs, in a minute");
  command.add_flag("--software", options->only_software,
                   "only the software renderer, beside software OpenGL");
  command.add_flag("--gpu", options->gpu, "fail on software OpenGL");
  command.add_option("--json", options->json,
                     "also write the report to this file; - is standard output");
  command.callback([options, &exit_code] {
    const auto report = write_render_report(*options);
    const auto written = report ? write_files(*options, *report) : tl::unexpected(report.error());
    if (written) return;
    print_error("pointreel-bench", written.error().message);
    exit_code = 1;
  });
}

}  // namespace pointreel::bench
