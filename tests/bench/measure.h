#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/process/print.h"

/// The tools of every benchmark: repeated timing, bars, and a description of the machine.
namespace pointreel::bench {

/// The times of several runs in milliseconds.
struct Timing {
  double median = 0.0, min = 0.0, max = 0.0;
};

/// The milliseconds of each of `runs` calls, after one call that is not timed.
template <class Work>
std::vector<double> time_runs(int runs, const Work& work);

/// The summary of time_runs.
template <class Work>
Timing measure(int runs, const Work& work);

/// A figure and the limit that it should meet.
struct Bar {
  std::string name;
  double value;
  std::string unit;
  double limit;
  bool at_least = false;  ///< the value must be at least the limit; otherwise at most

  bool holds() const { return at_least ? value >= limit : value <= limit; }
};

/// Processor, number of cores, compiler, build type and commit.
nlohmann::json machine();

nlohmann::json to_json(const Timing& timing);
using pointreel::print;

/// Bars are those of the full run: the figures of a quick one are not judged, and to_json has no
/// "holds" for them.
nlohmann::json to_json(const std::vector<Bar>& bars, bool quick);
void print(const std::vector<Bar>& bars, bool quick);
/// The chapter about the "bars" of a report in Markdown.
std::string bars_chapter(const nlohmann::json& report);

Timing summarise(std::vector<double> milliseconds);
double now_ms();

template <class Work>
std::vector<double> time_runs(int runs, const Work& work) {
  work();
  std::vector<double> milliseconds;
  for (int i = 0; i < runs; ++i) {
    const double begin = now_ms();
    work();
    milliseconds.push_back(now_ms() - begin);
  }
  return milliseconds;
}

template <class Work>
Timing measure(int runs, const Work& work) {
  return summarise(time_runs(runs, work));
}

}  // namespace pointreel::bench
