#include "tests/bench/measure.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <thread>

#include <fmt/format.h>

#include "common/process/print.h"
#include "tests/bench/table.h"

namespace pointreel::bench {
namespace {

constexpr const char* kNotJudged =
    "With --quick no bar is judged: the bars are those of the full run.";

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

nlohmann::json to_json(const std::vector<Bar>& bars, bool quick) {
  auto list = nlohmann::json::array();
  for (const Bar& bar : bars) {
    list.push_back(
        {{"name", bar.name}, {"value", bar.value}, {"unit", bar.unit}, {"limit", bar.limit}});
    if (!quick) list.back()["holds"] = bar.holds();
  }
  return list;
}

void print(const std::vector<Bar>& bars, bool quick) {
  if (bars.empty()) return;
  print("\n");
  if (quick) print("{}\n", kNotJudged);
  for (const Bar& bar : bars) {
    if (quick) {
      print("      {:<52} {:>9.3f} {}\n", bar.name, bar.value, bar.unit);
    } else {
      print("{} {:<52} {:>9.3f} {:<4} (bar: {} {:g})\n", bar.holds() ? "holds" : "FAILS", bar.name,
            bar.value, bar.unit, bar.at_least ? "at least" : "at most", bar.limit);
    }
  }
}

std::string bars_chapter(const nlohmann::json& report) {
  if (report["quick"].get<bool>()) return fmt::format("## Bars\n\n{}\n", kNotJudged);
  Table table({"bar", "value", "limit", ""});
  for (const nlohmann::json& bar : report["bars"]) {
    const auto with_unit = [&](const char* key) {
      const std::string unit = bar["unit"];
      return fmt::format("{:.4g}{}{}", bar[key].get<double>(), unit.empty() ? "" : " ", unit);
    };
    table.row({bar["name"], with_unit("value"), with_unit("limit"),
               bar.value("holds", false) ? "holds" : "**fails**"});
  }
  return "## Bars\n\nThe limits that these figures should meet.\n\n" + table.text();
}

}  // namespace pointreel::bench
