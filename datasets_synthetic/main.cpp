// pointreel-synth: writes synthetic sequences with a known surface, and difficult files, as PLY.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>
#include <tbb/info.h>

#include "common/base/words.h"
#include "common/command_line/command.h"
#include "common/process/print.h"
#include "common/process/run_main.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/write_hard.h"
#include "datasets_synthetic/write_sequence.h"

namespace pointreel {
namespace {

constexpr const char* kHard = "hard";
constexpr const char* kHardSummary = "difficult files, to test programs that read point clouds";

const std::map<std::string, Sampler> kSamplers = {{"scan", Sampler::scan},
                                                  {"uniform", Sampler::uniform},
                                                  {"ldc", Sampler::ldc},
                                                  {"depth-cameras", Sampler::depth_cameras}};

struct Options {
  std::string name;
  SequenceJob job;
  int frames = 0;        // 0: the length of the motion
  double spacing = 4.0;  // millimetres
  int voxel_bits = 0;    // 0: no voxels
  int threads = 0;
  bool list = false;
  bool json = false;
};

void print_list(bool json) {
  nlohmann::json all = nlohmann::json::array();
  for (const Motion& motion : motions()) {
    all.push_back({{"name", motion.name}, {"summary", motion.summary}, {"poses", motion.poses}});
    if (!json) print("{:<16}{} ({} poses)\n", motion.name, motion.summary, motion.poses);
  }
  all.push_back({{"name", kHard}, {"summary", kHardSummary}});
  if (json) {
    print_json(all, -1);
  } else {
    print("{:<16}{}\n", kHard, kHardSummary);
  }
}

int report(const std::string& message, int code) {
  print_error("pointreel-synth", message);
  return code;
}

int run_hard(const Options& options) {
  const auto files = write_hard(options.job.output, options.job.force);
  if (!files) return report(files.error().message, 1);
  if (options.json) {
    print_json(nlohmann::json{{"output", options.job.output}, {"files", *files}}, -1);
  } else {
    print("{}: {}; {} says what reading each of them must give\n", options.job.output,
          counted(*files, "file"), kHardManifest);
  }
  return 0;
}

/// The summary that --json prints.
nlohmann::json summary_json(const Options& options, const SequenceJob& job,
                            const SequenceSummary& summary, std::size_t threads) {
  const SequenceOptions& sequence = job.options;
  nlohmann::json json{{"motion", options.name},
                      {"output", job.output},
                      {"frames", job.frames},
                      {"points", summary.mean_points},
                      {"points_min", summary.min_points},
                      {"points_max", summary.max_points},
                      {"fps", sequence.fps},
                      {"still", sequence.still},
                      {"threads", threads},
                      {"seconds", summary.seconds}};
  if (sequence.voxels) {
    const VoxelGrid& grid = *sequence.voxels;
    json["voxels"] = {{"bits", grid.bits},
                      {"edge", grid.voxel},
                      {"origin", {grid.origin.x, grid.origin.y, grid.origin.z}}};
    return json;
  }
  for (const auto& [name, sampler] : kSamplers) {
    if (sampler == sequence.sampler) json["sampler"] = name;
  }
  json["seed"] = sequence.seed;
  json["noise"] = sequence.noise;
  if (sequence.sampler == Sampler::depth_cameras) {
    json["cameras"] = sequence.depth_cameras.cameras;
    json["depth_noise"] = sequence.depth_cameras.noise;
    json["calibration_error"] = sequence.depth_cameras.calibration_shift;
  }
  if (sequence.sampler == Sampler::ldc) {
    json["spacing"] = sequence.ldc.spacing;
    json["reduced"] = sequence.ldc.reduce;
  }
  return json;
}

int run_sequence(const Motion& motion, const Options& options) {
  const auto threads = static_cast<std::size_t>(
      options.threads > 0 ? options.threads : tbb::info::default_concurrency());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  SequenceJob job = options.job;
  SequenceOptions& sequence = job.options;
  job.frames = options.frames > 0
                   ? options.frames
                   : std::max(1, static_cast<int>(std::round(motion.seconds() * sequence.fps)));
  sequence.ldc.spacing = 1e-3 * options.spacing;
  sequence.depth_cameras.calibration_turn =
      kTurnPerShift * sequence.depth_cameras.calibration_shift;
  if (options.voxel_bits > 0) {  // all frames share one grid, so that the voxels do not jump
    sequence.voxels = voxel_grid(
        sequence_bounds(motion, sequence.fps, sequence.still ? 1 : job.frames), options.voxel_bits);
  }
  const auto summary = write_sequence(motion, job);
  if (!summary) return report(summary.error().message, 1);
  if (options.json) {
    print_json(summary_json(options, job, *summary, threads), -1);
    return 0;
  }
  print("{}: {} of {:.0f} points on average in {:.1f} s ({:.1f} frames per second)\n", job.output,
        counted(static_cast<std::uint64_t>(job.frames), "frame"), summary->mean_points,
        summary->seconds, job.frames / summary->seconds);
  if (sequence.voxels) {
    const VoxelGrid& grid = *sequence.voxels;
    print("voxels of {:.4f} mm; voxel (0, 0, 0) is centred at ({:.4f}, {:.4f}, {:.4f}) m\n",
          1e3 * grid.voxel, grid.origin.x, grid.origin.y, grid.origin.z);
  }
  return 0;
}

/// Describes options that cannot be combined; empty if there are none.
std::string contradiction(cli::Command app, const Options& options) {
  const auto given = [&app](const char* name) { return app.count(name) > 0; };
  const bool ldc = options.job.options.sampler == Sampler::ldc;
  if (options.voxel_bits > 0) {
    for (const char* name : {"--sampler", "--points", "--seed", "--noise", "--spacing", "--reduce",
                             "--cameras", "--depth-noise", "--calibration-error"}) {
      if (given(name)) {
        return fmt::format("--voxelize writes every voxel: it cannot be combined with {}", name);
      }
    }
  }
  if (ldc && given("--points")) {
    return "--points cannot be combined with --sampler ldc; give --spacing instead";
  }
  for (const char* name : {"--spacing", "--reduce"}) {
    if (!ldc && given(name)) return fmt::format("{} needs --sampler ldc", name);
  }
  for (const char* name : {"--cameras", "--depth-noise", "--calibration-error"}) {
    if (options.job.options.sampler != Sampler::depth_cameras && given(name)) {
      return fmt::format("{} needs --sampler depth-cameras", name);
    }
  }
  return {};
}

int run(cli::Command app, const Options& options) {
  if (options.list) {
    print_list(options.json);
    return 0;
  }
  const bool hard = options.name == kHard;
  const Motion* motion = find_motion(options.name);
  if (options.name.empty()) return report("no name given; --list shows all names", 2);
  if (motion == nullptr && !hard) {
    return report(options.name + ": unknown name; --list shows all names", 2);
  }
  if (options.job.output.empty()) return report("no folder given to write to; add -o FOLDER", 2);
  if (hard) return run_hard(options);
  const std::string wrong = contradiction(app, options);
  if (!wrong.empty()) return report(wrong, 2);
  return run_sequence(*motion, options);
}

void add_options(cli::Command app, Options& options) {
  SequenceOptions& sequence = options.job.options;
  app.add_option("NAME", options.name, "a motion of the figure, or \"hard\"; --list shows them all")
      .type_name("");
  app.add_option("-o,--output", options.job.output, "the folder to write to; created if missing")
      .type_name("FOLDER");
  app.add_flag("--force", options.job.force, "replace the folder if this program wrote it");
  app.add_option("--frames", options.frames, "number of frames; 0: the length of the motion")
      .capture_default_str()
      .check(cli::range(0, 1000000));
  app.add_option("--fps", sequence.fps, "frames per second")
      .capture_default_str()
      .check(cli::number_within(0.001, 100000.0));
  app.add_flag("--still", sequence.still,
               "all frames show the pose of the first, and only their sampling differs, as if the "
               "figure stood still");
  app.add_option("--threads", options.threads, "number of threads; 0: one for each core")
      .capture_default_str()
      .check(cli::range(0, 1024));
  app.add_flag("--list", options.list, "list the names and exit");
  app.add_flag("--json", options.json, "print the summary as JSON");

  constexpr const char* kSampling = "Sampling of the surface";
  std::vector<std::string> samplers;
  for (const auto& [name, sampler] : kSamplers) samplers.push_back(name);
  app.add_option_function<std::string>(
         "--sampler",
         [&sequence](const std::string& name) { sequence.sampler = kSamplers.at(name); },
         "scan: curves that cameras see, with measurement errors; depth-cameras: depth images from "
         "all sides, with noise, flying pixels, badly aligned cameras and wrong colours at edges; "
         "uniform: random points on the surface, uniform by area; ldc: layered depth cube, where "
         "three bundles of parallel rays meet the surface")
      .check(cli::one_of(samplers))
      .type_name("NAME")
      .default_str("scan")
      .group(kSampling);
  app.add_option("--points", sequence.points,
                 "points per frame (scan, depth-cameras: on average over the motion); 0: as many "
                 "as the scanned "
                 "sequence of that name by Slomp et al. has, 61,000 to 102,000")
      .capture_default_str()
      .check(cli::range(0, 50000000))
      .group(kSampling);
  app.add_option("--seed", sequence.seed, "each seed gives another sample of the same surface")
      .capture_default_str()
      .check(cli::whole_number())
      .group(kSampling);
  app.add_option("--noise", sequence.noise,
                 "noise, in addition to that of the sampler: its standard deviation along each "
                 "axis in metres")
      .capture_default_str()
      .check(cli::number_within(0.0, 1.0))
      .group(kSampling);
  app.add_option("--cameras", sequence.depth_cameras.cameras,
                 "depth-cameras: number of cameras in a ring around the figure")
      .capture_default_str()
      .check(cli::range(1, 100))
      .group(kSampling);
  app.add_option("--depth-noise", sequence.depth_cameras.noise,
                 "depth-cameras: standard deviation in metres of the depth of a surface that faces "
                 "the camera at the distance of the ring, 2.3 m; it grows with the square of the "
                 "distance and with the slant")
      .capture_default_str()
      .check(cli::number_within(0.0, 0.1))
      .group(kSampling);
  app.add_option("--calibration-error", sequence.depth_cameras.calibration_shift,
                 "depth-cameras: how far in metres each camera is off its place, the same in all "
                 "frames; it is also turned, by 0.2 degrees for each 0.003 m")
      .capture_default_str()
      .check(cli::number_within(0.0, 0.1))
      .group(kSampling);
  app.add_option("--spacing", options.spacing, "ldc: distance between the rays in millimetres")
      .capture_default_str()
      .check(cli::number_within(0.1, 1000.0))
      .group(kSampling);
  app.add_flag("--reduce", sequence.ldc.reduce,
               "ldc: move points to where rays cross, and keep one in each place")
      .group(kSampling);
  app.add_option("--voxelize", options.voxel_bits,
                 "do not sample, but write every voxel that the surface passes through, with "
                 "integer coordinates of this many bits in one grid for all frames")
      .check(cli::range(1, 12))
      .group(kSampling);
}

int parse_and_run(int argc, char** argv) {
  cli::Program app{
      "Writes a synthetic sequence of point clouds, of a moving figure whose true surface is "
      "known, as frame_0000.ply, frame_0001.ply, ... The figure faces +z and stands on y = 0, "
      "with y up and coordinates in metres. All points have normals and colours. The same options "
      "give the same bytes on every machine.\n"
      "\n"
      "The name \"hard\" writes a collection of difficult files instead, with a manifest.json "
      "that says what reading each of them must give. It uses only -o, --force and --json.",
      "pointreel-synth"};
  app.footer("Exit codes: 0 success, 1 failure, 2 wrong usage.");
  Options options;
  add_options(app, options);
  app.add_common_options();
  if (const auto status = app.parse(argc, argv)) return *status;
  return run(app, options);
}

}  // namespace
}  // namespace pointreel

int main(int argc, char** argv) {
  return pointreel::run_main(
      "pointreel-synth", [&] { return pointreel::parse_and_run(argc, argv); },
      "not enough memory; try --threads 1 or fewer points");
}
