#include "tests/bench/stream/chapter.h"

#include <algorithm>
#include <cstdio>
#include <memory>

#include <fmt/format.h>

#include "common/process/print.h"
#include "tests/bench/output.h"
#include "tests/temporary_folder.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;

struct ChapterOptions {
  std::vector<std::string> only;
  std::string json;
  bool quick = false;
};

Result<json> run_chapters(const std::string& name, const std::vector<StreamChapter>& chapters,
                          const ChapterOptions& options) {
  const TemporaryFolder scratch;
  const double begin = now_ms();
  json report = {{"benchmark", name}, {"quick", options.quick}, {"machine", machine()}};
  std::vector<Bar> bars;
  for (const StreamChapter& chapter : chapters) {
    const bool wanted = options.only.empty() || std::find(options.only.begin(), options.only.end(),
                                                          chapter.name) != options.only.end();
    if (!wanted) continue;
    const double chapter_begin = now_ms();
    auto figures = chapter.run({options.quick, scratch.path()}, bars);
    if (!figures) return fail_at(chapter.name, figures.error());
    (*figures)["seconds"] = (now_ms() - chapter_begin) / 1000.0;
    if (options.json != "-") {
      print("{}: {}\n", chapter.name, chapter.about);
      print_json(*figures, 1);
      print("\n");
      std::fflush(stdout);
    }
    report[chapter.name] = *std::move(figures);
  }
  report["bars"] = to_json(bars, options.quick);
  report["seconds"] = (now_ms() - begin) / 1000.0;
  if (options.json != "-") print(bars, options.quick);
  return report;
}

}  // namespace

void add_chapters_command(cli::Command app, int& exit_code, const std::string& name,
                          const std::string& about, const std::vector<StreamChapter>& chapters) {
  const cli::Command command = app.add_subcommand(name, about);
  const auto options = std::make_shared<ChapterOptions>();
  std::vector<std::string> names;
  std::string list;
  for (const StreamChapter& chapter : chapters) {
    names.push_back(chapter.name);
    list += fmt::format("  {:<12} {}\n", chapter.name, chapter.about);
  }
  command.add_option("--only", options->only, "measure only these chapters")
      .check(cli::one_of(names))
      .type_name("CHAPTER");
  command.add_flag("--quick", options->quick, "fewer repetitions and frames");
  command
      .add_option("--json", options->json,
                  "also write the report to this file; with -, print only the report")
      .type_name("FILE");
  command.footer("Chapters:\n" + list);
  command.callback([name, chapters, options, &exit_code] {
    const auto report = run_chapters(name, chapters, *options);
    const auto written = !report                 ? tl::unexpected(report.error())
                         : options->json.empty() ? Result<void>{}
                                                 : write_json(options->json, *report);
    if (written) return;
    print_error("pointreel-bench", written.error().message);
    exit_code = 1;
  });
}

}  // namespace pointreel::bench
