#include <cstdio>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "common/command_line/command.h"
#include "common/process/print.h"
#include "tests/soak/scenario.h"
#include "tests/temporary_folder.h"

int main(int argc, char** argv) {
  using namespace pointreel::soak;
  pointreel::cli::Program app{
      "Streams packages and live streams at the same time, over links that slow down, break, "
      "corrupt bytes and recover.",
      "pointreel_soak"};
  app.footer("Exit status: 0 success, 1 failure, 2 wrong usage; sanitizers use their own.");
  int seconds = 10;
  Options options;
  app.add_option("--seconds", seconds, "duration of the scenarios, which run at the same time")
      .check(pointreel::cli::range(1, 1'000'000))
      .capture_default_str();
  app.add_option("--seed", options.seed, "seed of the random numbers").capture_default_str();
  app.add_common_options();
  if (const auto status = app.parse(argc, argv)) return *status;
  options.time = std::chrono::seconds(seconds);

  const pointreel::TemporaryFolder scratch;
  options.scratch = scratch.path();

  const std::vector<std::pair<const char*, Outcome (*)(const Options&)>> scenarios = {
      {"play a reel", play_reel}, {"watch live", watch_live}};
  std::vector<Outcome> outcomes(scenarios.size());
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    threads.emplace_back([&, i] { outcomes[i] = scenarios[i].second(options); });
  }
  for (std::thread& thread : threads) thread.join();
  bool good = true;
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    good = good && outcomes[i];
    pointreel::print("{}: {}\n", scenarios[i].first,
                     outcomes[i] ? *outcomes[i] : "FAILED: " + outcomes[i].error().message);
  }
  return good ? 0 : 1;
}
