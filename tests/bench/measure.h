#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

/// What every benchmark needs: repeated timing, bars, and a report that names the machine.
namespace pointreel::bench {

/// Milliseconds of one run each.
struct Timing {
  double median = 0.0, min = 0.0, max = 0.0;
};

/// Milliseconds of each of `runs` calls, after one that is not timed.
template <class Work>
std::vector<double> time_runs(int runs, const Work& work);

/// What these come to.
template <class Work>
Timing measure(int runs, const Work& work);

/// A limit that an issue sets on a figure.
struct Bar {
  std::string name;
  double value;
  std::string unit;
  double limit;
  bool at_least = false;  ///< else at most

  bool holds() const { return at_least ? value >= limit : value <= limit; }
};

/// Processor, cores, compiler, commit and build type.
nlohmann::json machine();

nlohmann::json to_json(const Timing& timing);
nlohmann::json to_json(const std::vector<Bar>& bars);
void print(const std::vector<Bar>& bars);

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
