#include <iostream>

#include <CLI/CLI.hpp>

#include "common/base/memory.h"
#include "tests/bench/compare.h"
#include "tests/bench/measure.h"
#include "tests/bench/output.h"
#include "tests/bench/player/player_command.h"
#include "tests/bench/render/render_command.h"
#include "tests/bench/render/truth_command.h"
#include "tests/bench/report/report.h"
#include "tests/bench/stream/stream_command.h"
#include "tests/bench/suites.h"
#include "tests/bench/training/train_command.h"

int main(int argc, char** argv) {
  using namespace pointreel::bench;
  pointreel::keep_freed_memory();
  CLI::App app{
      "Measures Pointreel: speed beside error, medians, and ratios against a peer or a "
      "reference in the same run.\nExit codes: 0 done, 1 could not read or write, 2 usage.",
      "pointreel-bench"};
  app.require_subcommand(1);
  SuiteOptions options;
  std::string json;
  const auto add = [&](const char* name, const char* help) {
    CLI::App* suite = app.add_subcommand(name, help);
    suite->add_flag("--quick", options.quick, "fewer runs and sizes");
    suite->add_option("--json", json, "write the report to this file, - for standard output");
    return suite;
  };
  CLI::App* svo = add("svo", "building octrees, against the paper's recursive build");
  CLI::App* codec = add("codec", "encoding and decoding, octree against Draco");
  codec->add_option("files", options.files, ".ply or .drc files to measure as well");
  int exit_code = 0;
  add_compare_command(app, exit_code);
  add_player_command(app, exit_code);
  add_render_command(app, exit_code);
  add_report_command(app, exit_code);
  add_stream_command(app, exit_code);
  add_train_command(app, exit_code);
  add_truth_command(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (!svo->parsed() && !codec->parsed()) return exit_code;
  nlohmann::json report = svo->parsed() ? run_svo(options) : run_codec(options);
  report["benchmark"] = svo->parsed() ? "svo" : "codec";
  report["machine"] = machine();
  if (json.empty()) return 0;
  const auto written = write_json(json, report);
  if (!written) std::cerr << "pointreel-bench: " << written.error().message << '\n';
  return written ? 0 : 1;
}
