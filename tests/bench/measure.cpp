#include "tests/bench/measure.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <thread>

#include <fmt/format.h>

#include "common/process/print.h"

namespace pointreel::bench {
namespace {

std::string processor_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

}  // namespace

double now_ms() {
  using namespace std::chrono;
  return duration<double, std::milli>(steady_clock::now().time_since_epoch()).count();
}

Timing summarise(std::vector<double> milliseconds) {
  if (milliseconds.empty()) return {};
  std::sort(milliseconds.begin(), milliseconds.end());
  return {milliseconds[milliseconds.size() / 2], milliseconds.front(), milliseconds.back()};
}

nlohmann::json machine() {
  return {{"processor", processor_name()},
          {"cores", std::thread::hardware_concurrency()},
          {"compiler", POINTREEL_COMPILER},
          {"build", POINTREEL_BUILD_TYPE},
          {"commit", POINTREEL_COMMIT}};
}

nlohmann::json to_json(const Timing& timing) {
  return {{"median", timing.median}, {"min", timing.min}, {"max", timing.max}};
}

nlohmann::json to_json(const std::vector<Bar>& bars) {
  auto list = nlohmann::json::array();
  for (const Bar& bar : bars) {
    list.push_back({{"name", bar.name},
                    {"value", bar.value},
                    {"unit", bar.unit},
                    {"limit", bar.limit},
                    {"holds", bar.holds()}});
  }
  return list;
}

void print(const std::vector<Bar>& bars) {
  print("\n");
  for (const Bar& bar : bars) {
    print("{:<5} {:<52} {:>9.3f} {:<4} (bar: {} {:g})\n", bar.holds() ? "holds" : "FAILS", bar.name,
          bar.value, bar.unit, bar.at_least ? "at least" : "at most", bar.limit);
  }
}

}  // namespace pointreel::bench
