#include "tests/bench/stream/stream_command.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "tests/bench/measure.h"
#include "tests/bench/output.h"
#include "tests/bench/stream/camera_path.h"
#include "tests/bench/stream/chapter.h"
#include "tests/bench/stream/faults.h"
#include "tests/bench/stream/live.h"
#include "tests/bench/stream/load.h"
#include "tests/bench/stream/memory.h"
#include "tests/bench/stream/rate_change.h"
#include "tests/bench/stream/seek.h"
#include "tests/bench/stream/start.h"
#include "tests/bench/stream/throughput.h"

namespace pointreel::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// In the order in which they run.
const std::vector<StreamChapter>& chapters() {
  static const std::vector<StreamChapter> kChapters = {
      {"start", "from an address to the first picture", run_start},
      {"seek", "from a jump, and the move of a drag, to the picture", run_seek},
      {"rate_change", "playing over 100, 5 and 100 Mbit/s", run_rate_change},
      {"camera_path", "bytes and pictures of a camera that comes nearer", run_camera_path},
      {"faults", "how soon playback goes on after links and servers failed", run_faults},
      {"live", "from capture to picture, and who is slow", run_live},
      {"load", "many viewers at once", run_load},
      {"throughput", "bytes over HTTP, against nginx", run_throughput},
      {"memory", "resident memory over frames and connections", run_memory}};
  return kChapters;
}

struct Options {
  std::vector<std::string> only;
  std::string json;
  bool quick = false;
};

/// A folder of its own that ends with its owner.
class Scratch {
 public:
  Scratch() {
    std::string name = (fs::temp_directory_path() / "pointreel-stream-XXXXXX").string();
    if (::mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ~Scratch() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

Result<json> run_chapters(const Options& options) {
  const Scratch scratch;
  if (scratch.path().empty()) {
    return fail(fs::temp_directory_path().string() + ": no folder can be made there");
  }
  const double begin = now_ms();
  json report = {{"benchmark", "stream"}, {"quick", options.quick}, {"machine", machine()}};
  std::vector<Bar> bars;
  for (const StreamChapter& chapter : chapters()) {
    const bool wanted = options.only.empty() || std::find(options.only.begin(), options.only.end(),
                                                          chapter.name) != options.only.end();
    if (!wanted) continue;
    const double chapter_begin = now_ms();
    auto figures = chapter.run({options.quick, scratch.path()}, bars);
    if (!figures) return fail_at(chapter.name, figures.error());
    (*figures)["seconds"] = (now_ms() - chapter_begin) / 1000.0;
    if (options.json != "-") {
      fmt::print("{}: {}\n{}\n\n", chapter.name, chapter.about, figures->dump(1));
      std::fflush(stdout);
    }
    report[chapter.name] = *std::move(figures);
  }
  report["bars"] = to_json(bars);
  report["seconds"] = (now_ms() - begin) / 1000.0;
  if (options.json != "-") print(bars);
  return report;
}

}  // namespace

void add_stream_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "stream", "first pictures, seeks, bad links, live, many viewers, memory; prints each bar");
  const auto options = std::make_shared<Options>();
  std::vector<std::string> names;
  std::string list;
  for (const StreamChapter& chapter : chapters()) {
    names.push_back(chapter.name);
    list += fmt::format("  {:<12} {}\n", chapter.name, chapter.about);
  }
  command->add_option("--only", options->only, "these chapters alone")
      ->check(CLI::IsMember(names))
      ->type_name("CHAPTER");
  command->add_flag("--quick", options->quick, "fewer repetitions and frames");
  command->add_option("--json", options->json, "write the report here, - for standard output");
  command->footer("Chapters:\n" + list);
  command->callback([options, &exit_code] {
    const auto report = run_chapters(*options);
    const auto written = !report                 ? tl::unexpected(report.error())
                         : options->json.empty() ? Result<void>{}
                                                 : write_json(options->json, *report);
    if (written) return;
    fmt::print(stderr, "pointreel-bench: {}\n", written.error().message);
    exit_code = 1;
  });
}

}  // namespace pointreel::bench
