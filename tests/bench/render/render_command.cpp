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

#include "client/render/gl_context.h"
#include "common/base/progress.h"
#include "tests/bench/measure.h"
#include "tests/bench/output.h"
#include "tests/bench/render/quality.h"
#include "tests/bench/render/render_markdown.h"

namespace pointreel::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Options {
  std::string folder = "render";
  std::string json;
  std::vector<std::string> scenes;
  bool quick = false;
  bool gpu = false;
};

/// How much is measured.
struct Effort {
  glm::ivec2 size;
  int views;
  std::size_t even_points;
  int runs;
};
const Effort kFull = {{1920, 1280}, 4, 250'000, 5};
const Effort kQuick = {{480, 320}, 2, 50'000, 1};

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

Result<json> measure_scene(Renderer& renderer, const SceneChoice& choice, const Effort& effort,
                           const fs::path& folder, Progress& progress) {
  const auto scene = make_render_scene(choice);
  if (!scene) return tl::unexpected(scene.error());
  const std::vector<PictureSetting> settings = picture_settings();
  const std::vector<Viewpoint> viewed = viewpoints(scene->truth, effort.size, effort.views);
  json views = json::array();
  for (const Viewpoint& viewpoint : viewed) {
    const ViewTruth view = make_view_truth(*scene, viewpoint, effort.size);
    json rows = json::array();
    for (const PictureSetting& setting : settings) {
      const auto quality = measure_quality(renderer, *scene, view, setting, views.empty());
      if (!quality) return fail_at(choice.name, quality.error());
      rows.push_back(quality->row);
      const std::string file = fmt::format("{}_{}_{}.png", file_name(choice.name),
                                           file_name(viewpoint.name), file_name(setting.name));
      const auto written =
          write_png((folder / file).string(), side_by_side(view.truth.image, quality->image));
      if (!written) return tl::unexpected(written.error());
      rows.back()["picture"] = file;
      progress.tick();
    }
    const auto covered = compare_coverage(view.truth.mask, view.truth.mask).truth;
    views.push_back({{"view", viewpoint.name},
                     {"coverage", covered},
                     {"distance", viewpoint.camera.distance},
                     {"rows", rows}});
  }
  const auto timings =
      time_settings(renderer, *scene, viewed.front().camera, effort.size, settings, effort.runs);
  if (!timings) return fail_at(choice.name, timings.error());
  for (std::size_t i = 0; i < settings.size(); ++i) {
    views[0]["rows"][i]["ms"] = to_json((*timings)[i]);
  }
  return json{{"scene", choice.name},
              {"motion", choice.motion->name},
              {"pose", choice.pose},
              {"dense", choice.even_points > 0},
              {"points", scene->surfels->cloud.size()},
              {"area", scene->area},
              {"spacing", scene->spacing},
              {"views", views}};
}

Result<json> write_render_report(const Options& options) {
  const double begin = now_ms();
  const Effort& effort = options.quick ? kQuick : kFull;
  const fs::path folder = options.folder;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string() + ": " + error.message());

  std::vector<SceneChoice> choices = scene_choices(1, effort.even_points);
  if (!options.scenes.empty()) {
    for (const std::string& name : options.scenes) {
      if (std::none_of(choices.begin(), choices.end(),
                       [&](const SceneChoice& choice) { return choice.name == name; })) {
        return fail("there is no scene \"" + name + "\" (\"" + choices.front().name + "\" is one)");
      }
    }
    std::erase_if(choices, [&](const SceneChoice& choice) {
      return std::find(options.scenes.begin(), options.scenes.end(), choice.name) ==
             options.scenes.end();
    });
  } else if (options.quick) {
    std::erase_if(choices, [](const SceneChoice& choice) {
      return choice.name != "soccer-shoot" && choice.even_points == 0;
    });
  }

  const auto context = OffscreenContext::create();
  if (!context) return tl::unexpected(context.error());
  const std::string gl = describe_opengl();
  const bool software = gl.find("llvmpipe") != std::string::npos;
  if (options.gpu && software) {
    return fail("--gpu asks for a graphics card, but this is software: " + gl);
  }
  fmt::print("{}\n", gl);
  auto renderer = Renderer::create();
  if (!renderer) return tl::unexpected(renderer.error());

  json report = {{"benchmark", "render"},
                 {"quick", options.quick},
                 {"machine", machine()},
                 {"size", {effort.size.x, effort.size.y}},
                 {"scenes", json::array()}};
  report["machine"]["gl_renderer"] = gl;
  Progress progress("render", choices.size() * static_cast<std::size_t>(effort.views) *
                                  picture_settings().size());
  for (const SceneChoice& choice : choices) {
    auto scene = measure_scene(*renderer, choice, effort, folder, progress);
    if (!scene) return tl::unexpected(scene.error());
    report["scenes"].push_back(std::move(*scene));
  }
  report["bars"] = to_json(std::vector<Bar>{});
  report["seconds"] = (now_ms() - begin) / 1000.0;
  return report;
}

Result<void> write_files(const Options& options, const json& report) {
  const fs::path folder = options.folder;
  const std::string text = to_render_markdown(report);
  if (options.json != "-") fmt::print("{}", text);
  if (auto written = write_text(folder / "report.md", text); !written) return written;
  if (auto written = write_text(folder / "report.json", report.dump(2) + "\n"); !written) {
    return written;
  }
  return options.json.empty() ? Result<void>{} : write_json(options.json, report);
}

}  // namespace

void add_render_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "render", "pictures of every mode against the true surface, and the times they take");
  const auto options = std::make_shared<Options>();
  command->add_option("-o,--output", options->folder, "folder to write to; made if it is missing")
      ->capture_default_str();
  command->add_option("--scene", options->scenes, "only this sequence; may be repeated");
  command->add_flag("--quick", options->quick, "two small scenes, few runs: half a minute");
  command->add_flag("--gpu", options->gpu, "fail on software OpenGL");
  command->add_option("--json", options->json, "also write the report here, - for standard output");
  command->callback([options, &exit_code] {
    const auto report = write_render_report(*options);
    const auto written = report ? write_files(*options, *report) : tl::unexpected(report.error());
    if (written) return;
    fmt::print(stderr, "pointreel-bench: {}\n", written.error().message);
    exit_code = 1;
  });
}

}  // namespace pointreel::bench
