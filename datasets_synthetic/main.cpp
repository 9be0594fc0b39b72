// pointreel-synth: writes synthetic sequences with a known surface as PLY files.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include "common/cloud/ply.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/sequences.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string motion;
  std::string output;
  int frames = 60;
  SequenceOptions sequence;
  int threads = 0;
  bool force = false;
  bool list = false;
  bool json = false;
};

void print_list(bool json) {
  nlohmann::json all = nlohmann::json::array();
  for (const Motion& motion : motions()) {
    all.push_back({{"name", motion.name}, {"summary", motion.summary}, {"poses", motion.poses}});
    if (!json) fmt::print("{:<16}{} ({} poses)\n", motion.name, motion.summary, motion.poses);
  }
  if (json) fmt::print("{}\n", all.dump());
}

/// Writes all frames into the folder `where`, several at a time.
Result<void> write_frames(const Motion& motion, const Options& options, const fs::path& where) {
  std::mutex mutex;
  std::optional<Error> first_error;
  std::atomic<bool> failed{false};
  tbb::parallel_for(0, options.frames, [&](int number) {
    if (failed) return;
    const auto cloud = sequence_frame(motion, options.sequence, number);
    const Result<void> written =
        cloud ? write_ply(where / fmt::format("frame_{:04}.ply", number), *cloud)
              : Result<void>(fail_at(fmt::format("frame {}", number), cloud.error()));
    if (!written) {
      const std::lock_guard lock(mutex);
      if (!first_error) first_error = written.error();
      failed = true;
    }
  });
  if (first_error) return tl::unexpected(*first_error);
  return {};
}

/// Writes the sequence beside its place and moves it there whole, so that the folder is complete or
/// absent. An existing folder is replaced only with --force, and only after all is written.
Result<void> write_sequence(const Motion& motion, const Options& options) {
  std::error_code error;
  const fs::path output = fs::absolute(options.output).lexically_normal();
  const fs::path place = output.has_filename() ? output : output.parent_path();
  const bool replaces =
      fs::exists(place, error) && !(fs::is_directory(place, error) && fs::is_empty(place, error));
  if (replaces && !options.force) {
    return fail(fmt::format("{}: exists; choose another folder or replace it with --force",
                            options.output));
  }
  if (replaces && !fs::is_directory(place, error)) {
    return fail(fmt::format("{}: is not a folder", options.output));
  }
  if (replaces) {  // never sweep away what this program did not write
    for (const auto& entry : fs::directory_iterator(place, error)) {
      const std::string name = entry.path().filename();
      if (!name.starts_with("frame_") || !name.ends_with(".ply")) {
        return fail(fmt::format("{}: holds {}, which is no frame of a sequence; move it away first",
                                options.output, name));
      }
    }
  }
  fs::path beside = place;
  beside += ".partial";
  fs::remove_all(beside, error);
  if (!fs::create_directories(beside, error)) {
    return fail(fmt::format("{}: cannot make the folder: {}", beside.string(), error.message()));
  }
  Result<void> written = write_frames(motion, options, beside);
  if (written) {
    fs::remove_all(place, error);
    if (!error) fs::rename(beside, place, error);
    if (error) written = fail(fmt::format("{}: {}", options.output, error.message()));
  }
  if (!written) fs::remove_all(beside, error);
  return written;
}

int run(const Options& options) {
  if (options.list) {
    print_list(options.json);
    return 0;
  }
  const Motion* motion = find_motion(options.motion);
  if (motion == nullptr || options.output.empty()) {
    fmt::print(stderr, "pointreel-synth: {}\n",
               motion != nullptr        ? "no folder to write to: give -o DIR"
               : options.motion.empty() ? "no motion given: --list names them"
                                        : options.motion + ": no such motion: --list names them");
    return 2;
  }
  const auto threads = static_cast<std::size_t>(
      options.threads > 0 ? options.threads : tbb::info::default_concurrency());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  const auto begin = std::chrono::steady_clock::now();
  const Result<void> written = write_sequence(*motion, options);
  if (!written) {
    fmt::print(stderr, "pointreel-synth: {}\n", written.error().message);
    return 1;
  }
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.json) {
    fmt::print("{}\n", nlohmann::json{{"motion", options.motion},
                                      {"output", options.output},
                                      {"frames", options.frames},
                                      {"points", options.sequence.points},
                                      {"fps", options.sequence.fps},
                                      {"seed", options.sequence.seed},
                                      {"noise", options.sequence.noise},
                                      {"threads", threads},
                                      {"seconds", seconds}}
                           .dump());
  } else {
    fmt::print("{}: {} frames of {} points in {:.1f} s ({:.1f} frames a second)\n", options.output,
               options.frames, options.sequence.points, seconds, options.frames / seconds);
  }
  return 0;
}

int parse_and_run(int argc, char** argv) {
  CLI::App app{
      "Writes a synthetic sequence with a known surface: frame_0000.ply, frame_0001.ply, ... in\n"
      "metres, y up, standing on y = 0, facing +z, with normals and colours. The same options "
      "give\n"
      "the same bytes on every machine.\n"
      "Exit codes: 0 written, 1 it failed, 2 wrong options.",
      "pointreel-synth"};
  Options options;
  app.add_option("motion", options.motion, "what the figure does (--list)");
  app.add_option("-o,--output", options.output, "folder to write to; made if it is missing");
  app.add_option("--frames", options.frames, "number of frames")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  app.add_option("--points", options.sequence.points, "points a frame")
      ->capture_default_str()
      ->check(CLI::Range(1, 50000000));
  app.add_option("--fps", options.sequence.fps, "frames a second")
      ->capture_default_str()
      ->check(CLI::Range(0.001, 100000.0));
  app.add_option("--seed", options.sequence.seed, "chooses another sample of the same surface")
      ->capture_default_str();
  app.add_option("--noise", options.sequence.noise, "standard deviation along each axis, metres")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--threads", options.threads, "0: one for each core")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  app.add_flag("--force", options.force, "replace an existing sequence");
  app.add_flag("--list", options.list, "name the motions");
  app.add_flag("--json", options.json, "print what was done as JSON");
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "pointreel-synth: {} (--help shows the options)\n", error.what());
    return 2;
  }
  return run(options);
}

}  // namespace
}  // namespace pointreel

int main(int argc, char** argv) {
  try {
    return pointreel::parse_and_run(argc, argv);
  } catch (const std::exception& error) {  // out of memory, mostly
    std::fprintf(stderr, "pointreel-synth: %s\n", error.what());
    return 1;
  }
}
