#include "tests/bench/render/software.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "client/prepare/prepare.h"
#include "client/render/software/software_renderer.h"
#include "client/render/supersampling.h"
#include "client/source/open_source.h"
#include "common/base/enum_names.h"
#include "common/base/try.h"
#include "common/threads/tbb_executor.h"
#include "datasets_synthetic/sequences.h"
#include "tests/bench/measure.h"
#include "tests/bench/program.h"
#include "tests/bench/render/playback.h"
#include "tests/bench/render/quality.h"
#include "tests/bench/render/truth.h"

namespace pointreel::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr glm::ivec2 kSize(1280, 720);
constexpr int kGridBits = 10;

/// A sequence whose first frame is drawn.
struct Sequence {
  std::string name;
  std::vector<std::string> options;  ///< of pointreel-synth
  bool voxelized = false;            ///< with integer coordinates
};

struct Figures {
  TruthScene truth;
  glm::dvec3 origin{0.0};  ///< of the source's coordinates, metres
  double unit = 1.0;       ///< of the source's coordinates, metres
};

Result<Figures> make_figures(const Sequence& sequence, int frames) {
  const Motion* motion = find_motion(sequence.options.front());
  SequenceOptions options;
  Figures figures{TRY(make_truth_scene(pose_body(motion->pose(0.0))))};
  if (sequence.voxelized) {
    const VoxelGrid grid = voxel_grid(sequence_bounds(*motion, options.fps, frames), kGridBits);
    figures.origin = grid.origin;
    figures.unit = grid.voxel;
  }
  return figures;
}

/// The camera of a picture of the source, in metres.
Camera in_metres(Camera camera, const Figures& figures) {
  camera.target = figures.origin + figures.unit * camera.target;
  camera.distance *= figures.unit;
  camera.scene_radius *= figures.unit;
  return camera;
}

Result<std::shared_ptr<const SceneFrame>> first_frame(const std::string& reel, DrawMode mode) {
  const auto source = TRY(open_source(reel));
  PrepareOptions options;
  options.mode = mode;
  const FetchedFrame fetched = TRY(source->fetch({}));
  return std::make_shared<const SceneFrame>(
      TRY(prepare_frame(fetched, frame_info(source->manifest(), 0), options)));
}

DrawOptions options_of(DrawMode mode) {
  DrawOptions options;
  options.mode = mode;
  options.smooth_outlines = true;  // as the player draws by default
  return options;
}

json to_json(const SoftwareStages& stages) {
  return {{"warp", stages.warp},
          {"visibility", stages.visibility},
          {"shading", stages.shading},
          {"reconstruction", stages.reconstruction},
          {"clear", stages.clear}};
}

/// Draws with both renderers in turns, each time from slightly farther to the side, so that nothing
/// is left from the picture before.
Result<json> measure_mode(Renderer& opengl, SoftwareRenderer& software, const std::string& reel,
                          const Figures& figures, DrawMode mode, int runs) {
  const auto frame = TRY(first_frame(reel, mode));
  const DrawOptions options = options_of(mode);
  Camera camera;
  camera.frame_bounds(frame->boxes.main, static_cast<double>(kSize.x) / kSize.y);
  const TruthPicture truth = cast_truth(figures.truth, in_metres(camera, figures), kSize, {});
  json row = {{"mode", name(mode)}};
  row["software"] =
      picture_errors(truth, TRY(draw_picture(software, frame, camera, kSize, options)));
  row["opengl"] = picture_errors(truth, TRY(draw_picture(opengl, frame, camera, kSize, options)));
  std::vector<double> software_ms, opengl_ms, cut_ms;
  SoftwareStages stages;
  for (int i = -1; i < runs; ++i) {
    camera.yaw += 1e-4;
    const DrawStats by_software = TRY(software.draw(frame, camera, kSize, options));
    const DrawStats by_opengl = TRY(opengl.draw(frame, camera, kSize, options));
    row["drawn"] = by_software.drawn;
    if (i < 0) continue;
    software_ms.push_back(by_software.render_ms);
    opengl_ms.push_back(by_opengl.render_ms);
    cut_ms.push_back(by_software.cut_ms);
    stages.warp += software.stages().warp / runs;
    stages.visibility += software.stages().visibility / runs;
    stages.shading += software.stages().shading / runs;
    stages.reconstruction += software.stages().reconstruction / runs;
    stages.clear += software.stages().clear / runs;
  }
  row["software"]["ms"] = bench::to_json(summarise(software_ms));
  row["opengl"]["ms"] = bench::to_json(summarise(opengl_ms));
  row["cut_ms"] = bench::to_json(summarise(cut_ms));
  row["stages"] = to_json(stages);
  return row;
}

/// The largest change between neighbouring pictures while the camera moves away to 2.5 times its
/// distance, as rms over the figure's pixels of the first picture, in steps of 1/255.
Result<json> measure_dolly(Renderer& opengl, SoftwareRenderer& software, const std::string& reel,
                           const Figures& figures, bool quick) {
  const glm::ivec2 size = quick ? glm::ivec2(160, 90) : glm::ivec2(480, 270);
  const int pictures = quick ? 6 : 72, supersample = quick ? 2 : 3;
  const auto frame = TRY(first_frame(reel, DrawMode::surfel));
  Camera camera;
  camera.frame_bounds(frame->boxes.main, static_cast<double>(size.x) / size.y);
  const double first = camera.distance;
  struct Series {
    std::vector<double> changes;
    Image before = {};

    void add(const Image& image) {
      if (!before.pixels.empty()) changes.push_back(difference(before, image).rms);
      before = image;
    }
    json result() const {
      return {{"largest", *std::max_element(changes.begin(), changes.end())}, {"changes", changes}};
    }
  };
  Series by_software, by_opengl, by_truth;
  for (int i = 0; i < pictures; ++i) {
    camera.distance = first * std::pow(2.5, static_cast<double>(i) / (pictures - 1));
    const DrawOptions options = options_of(DrawMode::surfel);
    by_software.add(TRY(draw_picture(software, frame, camera, size, options)).image);
    by_opengl.add(TRY(draw_picture(opengl, frame, camera, size, options)).image);
    by_truth.add(average_squares(
        cast_truth(figures.truth, in_metres(camera, figures), supersample * size, {}).image,
        supersample));
  }
  return json{{"software", by_software.result()},
              {"opengl", by_opengl.result()},
              {"truth", by_truth.result()}};
}

}  // namespace

Result<json> measure_software(Renderer& opengl, const fs::path& folder, bool quick) {
  SoftwareRenderer software(tbb_executor());
  const fs::path scratch = folder / ".software";
  const std::string clouds = scratch / "clouds", reel = scratch / "reel";
  const int count = quick ? 2 : 60;
  const std::string frames = std::to_string(count);
  const std::vector<Sequence> sequences = {
      {"soccer-shoot", {"soccer-shoot", "--frames", frames}},
      {"kick, dense", {"kick", "--voxelize", std::to_string(kGridBits), "--frames", frames}, true}};
  const auto measure = [&]() -> Result<json> {
    json out = {{"renderer", software.describe()}, {"sequences", json::array()}};
    for (const Sequence& sequence : sequences) {
      std::error_code ignored;
      fs::remove_all(scratch, ignored);
      std::vector<std::string> synth = sequence.options;
      synth.insert(synth.end(), {"-o", clouds});
      TRY(run_program("pointreel-synth", synth));
      TRY(run_program("pointreel-server", {"pack", "-i", clouds, "-o", reel, "--codec", "octree"}));
      const Figures figures = TRY(make_figures(sequence, count));
      json result = {
          {"name", sequence.name}, {"modes", json::array()}, {"playback", json::array()}};
      for (const auto& mode : kEnumNames<DrawMode>)
        result["modes"].push_back(
            TRY(measure_mode(opengl, software, reel, figures, mode.value, quick ? 3 : 31)));
      for (const char* renderer : {"software", "opengl"}) {
        json row = TRY(play_reel(reel, "surfel", renderer));
        row["renderer"] = renderer;
        result["playback"].push_back(std::move(row));
      }
      if (sequence.voxelized)
        out["dolly"] = TRY(measure_dolly(opengl, software, reel, figures, quick));
      out["sequences"].push_back(std::move(result));
    }
    return out;
  };
  auto measured = measure();
  std::error_code ignored;
  fs::remove_all(scratch, ignored);
  return measured;
}

}  // namespace pointreel::bench
