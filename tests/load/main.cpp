// pointreel-load: many viewers of one server.

#include <cstdio>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/base/words.h"
#include "common/command_line/command.h"
#include "common/process/print.h"
#include "common/process/standard_output.h"
#include "tests/load/load_generator.h"

namespace {

int run(int argc, char** argv) {
  pointreel::cli::Program app{
      "Simulates many viewers of a package or a live stream and measures how late their frames "
      "arrive. The viewers decode nothing.",
      "pointreel-load"};
  app.footer("Exit status: 0 success, 1 failure or a broken connection, 2 wrong usage.");
  pointreel::LoadOptions options;
  bool json = false;
  app.add_option("url", options.url,
                 "http://ADDRESS:PORT/NAME for a package, ws://ADDRESS:PORT/live/NAME for a live "
                 "stream; ADDRESS must be numeric, such as 127.0.0.1")
      .required();
  app.add_option("--viewers", options.viewers, "number of viewers").capture_default_str();
  app.add_option("--seconds", options.seconds, "how long to measure")
      .check(pointreel::cli::positive_number())
      .capture_default_str();
  app.add_option("--warm-up", options.warm_up, "seconds before the measurement starts")
      .check(pointreel::cli::number_within(0.0, 86'400.0))
      .capture_default_str();
  app.add_option("--token", options.token, "bearer token, if the server requires one");
  app.add_flag("--json", json, "print the figures as JSON");
  using namespace pointreel;
  app.add_common_options();
  if (const auto status = app.parse(argc, argv)) return *status;
  const auto figures = run_load(options);
  if (!figures) {
    print_error("pointreel-load", figures.error().message);
    return 1;
  }
  if (json) {
    const nlohmann::json report = {{"viewers", options.viewers},
                                   {"seconds", figures->seconds},
                                   {"frames", figures->frames},
                                   {"incomplete", figures->incomplete},
                                   {"missing", figures->missing},
                                   {"broken", figures->broken},
                                   {"bits_per_second", figures->bits_per_second()},
                                   {"cpu_seconds", figures->cpu_seconds},
                                   {"delay_ms",
                                    {{"p50", figures->delay_ms(0.5)},
                                     {"p95", figures->delay_ms(0.95)},
                                     {"p99", figures->delay_ms(0.99)}}}};
    print_json(report, 1);
  } else {
    print("{}, {:.1f} Mbit/s in total; {} complete, {} incomplete, {} missing; {} broken\n",
          counted(static_cast<std::uint64_t>(options.viewers), "viewer"),
          figures->bits_per_second() / 1e6, counted(figures->frames, "frame"), figures->incomplete,
          figures->missing, counted(figures->broken, "connection"));
    print(
        "frame delay: median {:.2f} ms, 95 % {:.2f} ms, 99 % {:.2f} ms; this program used "
        "{:.0f} % of a core\n",
        figures->delay_ms(0.5), figures->delay_ms(0.95), figures->delay_ms(0.99),
        100.0 * figures->cpu_seconds / figures->seconds);
  }
  return figures->broken > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  return pointreel::finish_output("pointreel-load", run(argc, argv));
}
