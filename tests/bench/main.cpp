#include "common/command_line/command.h"
#include "common/process/memory.h"
#include "common/process/print.h"
#include "common/process/standard_output.h"
#include "tests/bench/compare.h"
#include "tests/bench/measure.h"
#include "tests/bench/output.h"
#include "tests/bench/player/player_command.h"
#include "tests/bench/render/render_command.h"
#include "tests/bench/render/truth_command.h"
#include "tests/bench/report/report.h"
#include "tests/bench/scale/scale_command.h"
#include "tests/bench/stream/stream_command.h"
#include "tests/bench/suites.h"
#include "tests/bench/surface/surface_command.h"
#include "tests/bench/training/train_command.h"

namespace {

int run(int argc, char** argv) {
  using namespace pointreel::bench;
  pointreel::keep_freed_memory();
  pointreel::cli::Program app{
      "Measures the speed and the errors of Pointreel. Times are medians, and ratios compare with "
      "another program or a reference implementation that was measured in the same run.\n"
      "\"pointreel-bench SUBCOMMAND --help\" shows the options of a subcommand.",
      "pointreel-bench"};
  app.footer("Exit status: 0 success, 1 failure, 2 wrong usage.");
  app.require_subcommand(1, 1);
  SuiteOptions options;
  std::string json;
  const auto add = [&](const char* name, const char* help) {
    const pointreel::cli::Command suite = app.add_subcommand(name, help);
    suite.add_flag("--quick", options.quick, "fewer runs and fewer sizes");
    suite.add_option("--json", json, "also write the report to this file; - is standard output")
        .type_name("FILE");
    return suite;
  };
  const pointreel::cli::Command svo =
      add("svo", "building octrees, compared with a recursive build, and traversing them");
  const pointreel::cli::Command codec =
      add("codec", "encoding and decoding: the octree codec compared with Draco");
  codec.add_option("files", options.files, "more clouds to measure, .ply or .drc");
  const pointreel::cli::Command strips =
      add("strips", "making triangle strips of surfels, and drawing both with the processor");
  strips.add_option("files", options.files, "more clouds to measure, .ply or .drc");
  const pointreel::cli::Command files =
      add("files", "reading files of points, compared with reading their bytes into memory");
  files.add_option("files", options.files, "more files to measure, of any format");
  const pointreel::cli::Command scalars =
      add("scalars", "coding scalar fields, compared with zstd of their floats");
  scalars.add_option("files", options.files, "more clouds to measure, .ply or .drc");
  int exit_code = 0;
  add_compare_command(app, exit_code);
  add_player_command(app, exit_code);
  add_render_command(app, exit_code);
  add_report_command(app, exit_code);
  add_scale_command(app, exit_code);
  add_stream_command(app, exit_code);
  add_surface_command(app, exit_code);
  add_train_command(app, exit_code);
  add_truth_command(app, exit_code);
  app.add_common_options();
  if (const auto status = app.parse(argc, argv)) return *status;
  nlohmann::json report;
  if (svo.parsed())
    report = run_svo(options);
  else if (codec.parsed())
    report = run_codec(options);
  else if (strips.parsed())
    report = run_strips(options);
  else if (files.parsed())
    report = run_files(options);
  else if (scalars.parsed())
    report = run_scalars(options);
  else
    return exit_code;
  if (report.contains("error")) {
    pointreel::print_error("pointreel-bench", report["error"].get<std::string>());
    return 1;
  }
  report["benchmark"] = app.parsed_subcommands().front().name();
  report["machine"] = machine();
  if (json.empty()) return 0;
  const auto written = write_json(json, report);
  if (!written) pointreel::print_error("pointreel-bench", written.error().message);
  return written ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  return pointreel::finish_output("pointreel-bench", run(argc, argv));
}
