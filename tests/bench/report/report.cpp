#include "tests/bench/report/report.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "common/base/progress.h"
#include "tests/bench/measure.h"
#include "tests/bench/output.h"
#include "tests/bench/report/datasets.h"
#include "tests/bench/report/markdown.h"
#include "tests/bench/report/memory.h"
#include "tests/bench/report/plot.h"
#include "tests/bench/report/rates.h"
#include "tests/bench/report/settings.h"
#include "tests/bench/report/structure.h"
#include "tests/e2e/process.h"
#include "tests/stability/check.h"

namespace pointreel::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// How much is measured.
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

/// Rates of one dataset with the memory that was measured before.
void add_memory(json& rates, const json& memory) {
  for (std::size_t i = 0; i < rates["rows"].size(); ++i) rates["rows"][i].update(memory["rows"][i]);
}

/// Makes the sequence as a user would and measures the memory of packing it at every setting. To
/// be done while this process is small: a child's peak begins at that of its parent.
Result<json> measure_programs(const Dataset& dataset, const std::vector<Setting>& settings,
                              int poses, const fs::path& scratch, Progress& progress) {
  const fs::path input = scratch / "input";
  std::vector<std::string> arguments = dataset.synth_arguments;
  arguments.insert(arguments.end(), {"-o", input.string(), "--force", "--json", "--frames",
                                     std::to_string(std::min(poses, dataset.motion->poses))});
  const e2e::Outcome made = e2e::run("pointreel-synth", arguments);
  if (made.exit_code != 0) return fail(dataset.name + ": " + made.err);
  const json summary = json::parse(made.out, nullptr, false);
  if (summary.is_discarded()) return fail(dataset.name + ": pointreel-synth printed no JSON");
  progress.tick();
  json rows = json::array();
  for (const Setting& setting : settings) {
    const auto peak = measure_memory(input, setting, scratch);
    if (!peak) return fail_at(dataset.name, peak.error());
    rows.push_back({{"pack_mib", peak->pack}, {"unpack_mib", peak->unpack}});
    progress.tick();
  }
  return json{
      {"frames_per_second", summary["frames"].get<double>() / summary["seconds"].get<double>()},
      {"rows", rows}};
}

/// One panel a dataset: for each codec, x against y of its settings, coarse to fine.
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
      if (px > 0.0 && py > 0.0) series->points.emplace_back(px, py);  // exact has no place here
    }
    out.push_back(panel);
  }
  return out;
}

/// One panel a dataset: the luma of each quality of the octree's colours against their size.
std::vector<Panel> color_panels(const json& codecs) {
  std::vector<Panel> out;
  for (const json& dataset : codecs) {
    Panel panel{
        dataset["dataset"], "colours, bits a point", "luma PSNR, dB", true, false, {}, "", 0.0};
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
  auto size_truth =
      panels(codecs, "geometry, bits a point", "mean distance to truth, mm", geometry_bits, truth);
  for (std::size_t i = 0; i < size_truth.size(); ++i) {
    size_truth[i].level_title = "source";
    size_truth[i].level = 1000.0 * codecs[i]["truth"]["mean"].get<double>();
    size_truth[i].log_x = false;
  }
  auto size_d1 = panels(codecs, "geometry, bits a point", "distance to source (D1 rms), mm",
                        geometry_bits, d1);
  for (Panel& panel : size_d1) panel.log_x = false;
  const std::string d1_label = "distance to source (D1 rms), mm";
  const std::pair<const char*, std::vector<Panel>> plots[] = {
      {"size_truth.svg", size_truth},
      {"size_d1.svg", size_d1},
      {"size_luma.svg", color_panels(codecs)},
      {"encode_d1.svg", panels(codecs, "encode, ms", d1_label, median("encode_ms"), d1)},
      {"decode_d1.svg", panels(codecs, "decode, ms", d1_label, median("decode_ms"), d1)}};
  for (const auto& [file, drawn] : plots) {
    if (auto result = draw_plot(folder / file, drawn, kColumns); !result) return result;
  }
  return {};
}

std::vector<Bar> bars_of(const json& report) {
  std::vector<Bar> bars;
  const json& checks = report["stability"];
  const auto failed = std::count_if(checks.begin(), checks.end(),
                                    [](const json& check) { return !check["passed"].get<bool>(); });
  bars.push_back({"stability checks that fail", static_cast<double>(failed), "", 0.0});
  if (report["quick"].get<bool>()) return bars;  // the others are of whole sequences
  for (const json& sequence : report["structure"]) {
    const std::string name = sequence["dataset"];
    const auto off = [](const json& ours, const json& papers) {
      return 100.0 * std::abs(ours.get<double>() / papers.get<double>() - 1.0);
    };
    bars.push_back({name + ": points a pose off Table I",
                    off(sequence["points"]["mean"], sequence["paper"]["points"]), "%", 1.0});
    double leaves = 0.0, other_depth = 0.0;
    for (const json& row : sequence["rows"]) {
      leaves = std::max(leaves, off(row["leaves"], row["paper"]["leaves"]));
      const std::string depth = std::to_string(row["paper"]["depth"].get<int>());
      const double same = row["poses_by_depth"].value(depth, 0);
      other_depth =
          std::max(other_depth, 100.0 - 100.0 * same / sequence["measured_poses"].get<double>());
    }
    bars.push_back({name + ": leaves off Table III, worst delta", leaves, "%", 10.0});
    bars.push_back(
        {name + ": poses of another depth than Table III, worst delta", other_depth, "%", 10.0});
  }
  for (std::size_t i = 0; i < report["structure"].size(); ++i) {  // the dense one has no bar
    const json& dataset = report["codecs"][i];
    bars.push_back({dataset["dataset"].get<std::string>() + ": frames made a second",
                    dataset["frames_made_per_second"].get<double>(), "/s", 10.0, true});
  }
  return bars;
}

}  // namespace

Result<json> write_report(const fs::path& folder, bool quick) {
  const double begin = now_ms();
  const Effort& effort = quick ? kQuick : kFull;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string() + ": " + error.message());

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
      const auto measured = measure_programs(
          all[i], settings[i], all[i].options.voxels ? effort.dense_poses : effort.memory_poses,
          scratch.path(), progress);
      if (!measured) return tl::unexpected(measured.error());
      memory.push_back(*measured);
    }
  }
  json report = {{"quick", quick}, {"machine", machine()}};
  report["structure"] = json::array();
  for (const Dataset& dataset : scanned) {
    const auto structure =
        measure_structure(dataset, {effort.structure_poses, effort.timed_poses, effort.runs}, tick);
    if (!structure) return tl::unexpected(structure.error());
    report["structure"].push_back(*structure);
  }
  report["codecs"] = json::array();
  for (std::size_t i = 0; i < all.size(); ++i) {
    auto rates = measure_rates(all[i], rate_poses[i], settings[i], effort.runs, tick);
    if (!rates) return tl::unexpected(rates.error());
    add_memory(*rates, memory[i]);
    (*rates)["frames_made_per_second"] = memory[i]["frames_per_second"];
    report["codecs"].push_back(*rates);
  }
  report["stability"] = json::array();
  for (const stability::Check& check : stability::run_stability_checks()) {
    report["stability"].push_back(to_json(check));
  }
  const std::vector<Bar> bars = bars_of(report);
  report["bars"] = to_json(bars);
  report["seconds"] = (now_ms() - begin) / 1000.0;

  if (auto drawn = draw_plots(folder, report["codecs"]); !drawn) {
    return tl::unexpected(drawn.error());
  }
  for (const auto& [file, text] : {std::pair{"report.json", report.dump(2) + "\n"},
                                   std::pair{"report.md", to_markdown(report)}}) {
    if (auto written = write_text(folder / file, text); !written) {
      return tl::unexpected(written.error());
    }
  }
  print(bars);
  return report;
}

void add_report_command(CLI::App& app, int& exit_code) {
  struct Options {
    std::string folder = "report";
    bool quick = false;
  };
  CLI::App* command = app.add_subcommand(
      "report", "speed against error of everything, as report.md, report.json and plots");
  const auto options = std::make_shared<Options>();
  command->add_option("-o,--output", options->folder, "folder to write to; made if it is missing")
      ->capture_default_str();
  command->add_flag("--quick", options->quick, "few poses, settings and runs: a minute");
  command->callback([options, &exit_code] {
    const auto report = write_report(options->folder, options->quick);
    if (report) return;
    fmt::print(stderr, "pointreel-bench: {}\n", report.error().message);
    exit_code = 1;
  });
}

}  // namespace pointreel::bench
