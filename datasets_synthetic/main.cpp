// pointreel-synth: writes synthetic sequences with a known surface as PLY files.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include "common/cloud/ply.h"
#include "datasets_synthetic/hard_cases.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/sequences.h"
#include "datasets_synthetic/write_folder.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHard = "hard";
constexpr const char* kHardManifest = "manifest.json";
constexpr const char* kHardSummary = "files that programs for point clouds stumble over";

struct Options {
  std::string name;
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
  all.push_back({{"name", kHard}, {"summary", kHardSummary}});
  if (json) {
    fmt::print("{}\n", all.dump());
  } else {
    fmt::print("{:<16}{}, with {}\n", kHard, kHardSummary, kHardManifest);
  }
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

Result<void> write_sequence(const Motion& motion, const Options& options) {
  const auto is_frame = [](std::string_view name) {
    return name.starts_with("frame_") && name.ends_with(".ply");
  };
  return write_folder(options.output, options.force, is_frame, [&](const fs::path& folder) {
    return write_frames(motion, options, folder);
  });
}

Result<void> write_text(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text << std::flush;
  if (!file) return fail(fmt::format("{}: cannot be written", path.string()));
  return {};
}

Result<void> write_hard(const Options& options, const std::vector<HardCase>& cases) {
  const auto is_ours = [&cases](std::string_view name) {
    return name == kHardManifest || std::any_of(cases.begin(), cases.end(),
                                                [name](const auto& c) { return c.file == name; });
  };
  return write_folder(options.output, options.force, is_ours, [&](const fs::path& folder) {
    Result<void> written = write_text(folder / kHardManifest, hard_manifest(cases));
    for (const HardCase& c : cases) {
      if (written) written = write_text(folder / c.file, c.bytes);
    }
    return written;
  });
}

int report_failure(const Error& error) {
  fmt::print(stderr, "pointreel-synth: {}\n", error.message);
  return 1;
}

int run_hard(const Options& options) {
  const std::vector<HardCase> cases = hard_cases();
  const Result<void> written = write_hard(options, cases);
  if (!written) return report_failure(written.error());
  if (options.json) {
    fmt::print("{}\n", nlohmann::json{{"output", options.output}, {"files", cases.size()}}.dump());
  } else {
    fmt::print("{}: {} files, and {} with what each must give\n", options.output, cases.size(),
               kHardManifest);
  }
  return 0;
}

int run(const Options& options) {
  if (options.list) {
    print_list(options.json);
    return 0;
  }
  const bool hard = options.name == kHard;
  const Motion* motion = find_motion(options.name);
  if ((motion == nullptr && !hard) || options.output.empty()) {
    fmt::print(stderr, "pointreel-synth: {}\n",
               motion != nullptr || hard ? "no folder to write to: give -o DIR"
               : options.name.empty()    ? "no name given: --list shows them"
                                         : options.name + ": no such name: --list shows them");
    return 2;
  }
  if (hard) return run_hard(options);
  const auto threads = static_cast<std::size_t>(
      options.threads > 0 ? options.threads : tbb::info::default_concurrency());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  const auto begin = std::chrono::steady_clock::now();
  const Result<void> written = write_sequence(*motion, options);
  if (!written) return report_failure(written.error());
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.json) {
    fmt::print(
        "{}\n",
        nlohmann::json{{"motion", options.name},
                       {"output", options.output},
                       {"frames", options.frames},
                       {"sampler", options.sequence.sampler == Sampler::scan ? "scan" : "uniform"},
                       {"points", points_per_frame(*motion, options.sequence)},
                       {"fps", options.sequence.fps},
                       {"seed", options.sequence.seed},
                       {"noise", options.sequence.noise},
                       {"threads", threads},
                       {"seconds", seconds}}
            .dump());
  } else {
    fmt::print("{}: {} frames of about {} points in {:.1f} s ({:.1f} frames a second)\n",
               options.output, options.frames, points_per_frame(*motion, options.sequence), seconds,
               options.frames / seconds);
  }
  return 0;
}

int parse_and_run(int argc, char** argv) {
  CLI::App app{
      "Writes a synthetic sequence with a known surface: frame_0000.ply, frame_0001.ply, ... in\n"
      "metres, y up, standing on y = 0, facing +z, with normals and colours. The same options "
      "give\n"
      "the same bytes on every machine.\n"
      "\"hard\" writes a collection of difficult files instead; of the options below it knows "
      "--force and --json.\n"
      "Exit codes: 0 written, 1 it failed, 2 wrong options.",
      "pointreel-synth"};
  Options options;
  app.add_option("name", options.name, "what the figure does, or \"hard\" (--list)");
  app.add_option("-o,--output", options.output, "folder to write to; made if it is missing");
  app.add_option("--frames", options.frames, "number of frames")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  const std::map<std::string, Sampler> samplers = {{"scan", Sampler::scan},
                                                   {"uniform", Sampler::uniform}};
  app.add_option("--sampler", options.sequence.sampler,
                 "scan: curves that cameras see, with their errors; uniform: by area, exact")
      ->transform(CLI::CheckedTransformer(samplers));
  app.add_option("--points", options.sequence.points,
                 "points a frame, a scan's on average; 0: as the paper's sequence has")
      ->capture_default_str()
      ->check(CLI::Range(0, 50000000));
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
  app.add_flag("--force", options.force, "replace what is there if this program wrote it");
  app.add_flag("--list", options.list, "show the names");
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
