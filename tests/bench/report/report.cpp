#include "tests/bench/report/report.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/base/try.h"
#include "common/process/print.h"
#include "common/process/progress.h"
#include "tests/bench/measure.h"
#include "tests/bench/output.h"
#include "tests/bench/program.h"
#include "tests/bench/report/datasets.h"
#include "tests/bench/report/markdown.h"
#include "tests/bench/report/memory.h"
#include "tests/bench/report/plot.h"
#include "tests/bench/report/rates.h"
#include "tests/bench/report/settings.h"
#include "tests/bench/report/structure.h"
#include "tests/stability/check.h"

namespace pointreel::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The amount of work that a report takes.
struct Effort {
  int structure_poses, timed_poses;
  int rate_poses, dense_poses;
  int memory_poses;
  int runs;
  bool all_settings;
};
constexpr Effort kFull = {1'000'000, 5, 5, 2, 12, 5, true};
constexpr Effort kQuick = {2, 1, 1, 1, 1, 1, false};

/// A quick report leaves out what lies between the coarsest, the usual and the finest setting.
std::vector<Setting> settings_of(const Dataset& dataset, bool all) {
  std::vector<Setting> settings = report_settings(dataset.max_bits);
  if (!all) {
    std::erase_if(settings, [&](const Setting& setting) {
      return !setting.on_curve || (setting.bits != dataset.peak_bits && setting.bits != 8);
    });
  }
  return settings;
}

/// A folder for temporary files, emptied and removed again.
class Scratch {
 public:
  explicit Scratch(const fs::path& parent) : path_(parent / ".scratch") { clear(); }
  ~Scratch() { clear(); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const fs::path& path() const { return path_; }

 private:
  void clear() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  fs::path path_;
};

/// Adds the memory, which was measured earlier, to the rates of a dataset.
void add_memory(json& rates, const json& memory) {
  for (std::size_t i = 0; i < rates["rows"].size(); ++i) rates["rows"][i].update(memory["rows"][i]);
}

/// Makes the sequence as a user would, and measures the memory of packing it with every setting.
/// This must happen while this process is small, because the peak of a child starts at the size of
/// its parent.
Result<json> measure_programs(const Dataset& dataset, const std::vector<Setting>& settings,
                              int poses, const fs::path& scratch, Progress& progress) {
  const fs::path input = scratch / "input";
  std::vector<std::string> arguments = dataset.synth_arguments;
  arguments.insert(arguments.end(), {"-o", input.string(), "--force", "--json", "--frames",
                                     std::to_string(std::min(poses, dataset.motion->poses))});
  const e2e::Outcome made = TRY(run_program("pointreel-synth", arguments));
  const json summary = json::parse(made.out, nullptr, false);
  if (summary.is_discarded()) return fail("pointreel-synth: printed no JSON");
  progress.tick();
  json rows = json::array();
  for (const Setting& setting : settings) {
    const PeakMemory peak = TRY(measure_memory(input, setting, scratch));
    rows.push_back({{"pack_mib", peak.pack}, {"unpack_mib", peak.unpack}});
    progress.tick();
  }
  return json{
      {"frames_per_second", summary["frames"].get<double>() / summary["seconds"].get<double>()},
      {"rows", rows}};
}

/// One panel per dataset: for each codec, x and y of its settings from coarse to fine.
template <class X, class Y>
std::vector<Panel> panels(const json& codecs, const std::string& x_label,
                          const std::string& y_label, X x, Y y) {
  std::vector<Panel> out;
  for (const json& dataset : codecs) {
    Panel panel{dataset["dataset"], x_label, y_label, true, true, {}, "", 0.0};
    for (const json& row : dataset["rows"]) {
      if (!row["on_curve"].get<bool>()) continue;
      const std::string codec = row["codec"];
      auto series = std::find_if(panel.series.begin(), panel.series.end(),
                                 [&](const Series& s) { return s.title == codec; });
      if (series == panel.series.end()) {
        panel.series.push_back({codec, static_cast<int>(panel.series.size()), {}});
        series = panel.series.end() - 1;
      }
      const double px = x(row), py = y(row);
      if (px > 0.0 && py > 0.0) series->points.emplace_back(px, py);  // the axes are logarithmic
    }
    out.push_back(panel);
  }
  return out;
}

/// One panel per dataset: the luma PSNR of each colour quality of the octree over its size.
std::vector<Panel> color_panels(const json& codecs) {
  std::vector<Panel> out;
  for (const json& dataset : codecs) {
    Panel panel{
        dataset["dataset"], "colours, bits per point", "luma PSNR, dB", true, false, {}, "", 0.0};
    Series series{"octree", 0, {}};
    for (const json& row : dataset["rows"]) {
      const json& luma = row["color_psnr"]["y"];
      if (row["codec"] != "octree context" || row["coordinate_bits"] != dataset["peak_bits"] ||
          luma.is_null())
        continue;
      series.points.emplace_back(row["bits"]["colors"].get<double>(), luma.get<double>());
    }
    std::sort(series.points.begin(), series.points.end());
    panel.series.push_back(std::move(series));
    out.push_back(std::move(panel));
  }
  return out;
}

Result<void> draw_plots(const fs::path& folder, const json& codecs) {
  constexpr int kColumns = 2;
  const auto geometry_bits = [](const json& row) { return row["bits"]["geometry"].get<double>(); };
  const auto truth = [](const json& row) { return 1000.0 * row["truth"]["mean"].get<double>(); };
  const auto d1 = [](const json& row) { return 1000.0 * row["d1_rms"].get<double>(); };
  const auto median = [](const char* key) {
    return [key](const json& row) { return row[key]["median"].get<double>(); };
  };
  auto size_truth = panels(codecs, "geometry, bits per point", "mean distance to truth, mm",
                           geometry_bits, truth);
  for (std::size_t i = 0; i < size_truth.size(); ++i) {
    size_truth[i].level_title = "source";
    size_truth[i].level = 1000.0 * codecs[i]["truth"]["mean"].get<double>();
    size_truth[i].log_x = false;
  }
  const std::string d1_label = "distance to source (D1 rms), mm";
  auto size_d1 = panels(codecs, "geometry, bits per point", d1_label, geometry_bits, d1);
  for (Panel& panel : size_d1) panel.log_x = false;
  const std::pair<const char*, std::vector<Panel>> plots[] = {
      {"size_truth.svg", size_truth},
      {"size_d1.svg", size_d1},
      {"size_luma.svg", color_panels(codecs)},
      {"encode_d1.svg", panels(codecs, "encode, ms", d1_label, median("encode_ms"), d1)},
      {"decode_d1.svg", panels(codecs, "decode, ms", d1_label, median("decode_ms"), d1)}};
  for (const auto& [file, drawn] : plots) {
    TRY(draw_plot(folder / file, drawn, kColumns));
  }
  return {};
}

std::vector<Bar> bars_of(const json& report) {
  std::vector<Bar> bars;
  const json& checks = report["stability"];
  const auto failed = std::count_if(checks.begin(), checks.end(),
                                    [](const json& check) { return !check["passed"].get<bool>(); });
  bars.push_back({"failed stability checks", static_cast<double>(failed), "", 0.0});
  if (report["quick"].get<bool>()) return bars;  // the other bars are for whole sequences
  for (const json& sequence : report["structure"]) {
    const std::string name = sequence["dataset"];
    const auto off = [](const json& ours, const json& papers) {
      return 100.0 * std::abs(ours.get<double>() / papers.get<double>() - 1.0);
    };
    bars.push_back({name + ": points per pose, difference from Table I",
                    off(sequence["points"]["mean"], sequence["paper"]["points"]), "%", 1.0});
    double leaves = 0.0, other_depth = 0.0;
    for (const json& row : sequence["rows"]) {
      leaves = std::max(leaves, off(row["leaves"], row["paper"]["leaves"]));
      const std::string depth = std::to_string(row["paper"]["depth"].get<int>());
      const double same = row["poses_by_depth"].value(depth, 0);
      other_depth =
          std::max(other_depth, 100.0 - 100.0 * same / sequence["measured_poses"].get<double>());
    }
    bars.push_back({name + ": leaves, largest difference from Table III", leaves, "%", 10.0});
    bars.push_back(
        {name + ": poses with another depth than Table III, worst delta", other_depth, "%", 10.0});
  }
  for (std::size_t i = 0; i < report["structure"].size(); ++i) {  // the dense dataset has no bar
    const json& dataset = report["codecs"][i];
    bars.push_back({dataset["dataset"].get<std::string>() + ": frames generated per second",
                    dataset["frames_made_per_second"].get<double>(), "/s", 10.0, true});
  }
  return bars;
}

/// Measures everything and writes report.json, report.md and the plots into `folder`.
Result<void> write_report(const fs::path& folder, bool quick) {
  const double begin = now_ms();
  const Effort& effort = quick ? kQuick : kFull;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(ErrorCode::io, folder.string() + ": " + error.message());

  const std::vector<Dataset> scanned = scanned_datasets();
  std::vector<Dataset> all = scanned;
  all.push_back(dense_dataset());
  std::vector<std::vector<Setting>> settings;
  std::vector<std::vector<int>> rate_poses;
  std::size_t steps = 0;
  for (const Dataset& dataset : all) {
    settings.push_back(settings_of(dataset, effort.all_settings));
    rate_poses.push_back(spread(dataset.motion->poses,
                                dataset.options.voxels ? effort.dense_poses : effort.rate_poses));
    steps += 1 + settings.back().size() * (1 + rate_poses.back().size());
  }
  for (const Dataset& dataset : scanned) {
    steps += spread(dataset.motion->poses, effort.structure_poses).size();
  }
  Progress progress("report", steps);
  const auto tick = [&] { progress.tick(); };

  json memory = json::array();
  {
    const Scratch scratch(folder);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const int poses = all[i].options.voxels ? effort.dense_poses : effort.memory_poses;
      memory.push_back(TRY(measure_programs(all[i], settings[i], poses, scratch.path(), progress)));
    }
  }
  json report = {{"quick", quick}, {"machine", machine()}};
  report["structure"] = json::array();
  for (const Dataset& dataset : scanned) {
    report["structure"].push_back(TRY(measure_structure(
        dataset, {effort.structure_poses, effort.timed_poses, effort.runs}, tick)));
  }
  report["codecs"] = json::array();
  for (std::size_t i = 0; i < all.size(); ++i) {
    json rates = TRY(measure_rates(all[i], rate_poses[i], settings[i], effort.runs, tick));
    add_memory(rates, memory[i]);
    rates["frames_made_per_second"] = memory[i]["frames_per_second"];
    report["codecs"].push_back(std::move(rates));
  }
  report["stability"] = json::array();
  for (const stability::Check& check : stability::run_stability_checks()) {
    report["stability"].push_back(to_json(check));
  }
  const std::vector<Bar> bars = bars_of(report);
  report["bars"] = to_json(bars, quick);
  report["seconds"] = (now_ms() - begin) / 1000.0;

  TRY(draw_plots(folder, report["codecs"]));
  TRY(write_text(folder / "report.json", report.dump(2) + "\n"));
  TRY(write_text(folder / "report.md", to_markdown(report)));
  print(bars, quick);
  print("\nWritten: {}, and beside it report.json and the plots\n",
        (folder / "report.md").string());
  return {};
}

}  // namespace

void add_report_command(cli::Command app, int& exit_code) {
  struct Options {
    std::string folder = default_folder("report");
    bool quick = false;
  };
  const cli::Command command = app.add_subcommand(
      "report", "sizes, speeds and errors of everything, as report.md, report.json and plots");
  const auto options = std::make_shared<Options>();
  command.add_option("-o,--output", options->folder, "the folder to write to; created if missing")
      .type_name("DIR")
      .capture_default_str();
  command.add_flag("--quick", options->quick, "few poses, settings and runs; takes two minutes");
  command.callback([options, &exit_code] {
    const auto written = write_report(options->folder, options->quick);
    if (written) return;
    print_error("pointreel-bench", written.error().message);
    exit_code = 1;
  });
}

}  // namespace pointreel::bench
