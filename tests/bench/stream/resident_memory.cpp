#include "tests/bench/stream/resident_memory.h"

#include <fstream>
#include <string>

#include <fmt/format.h>

namespace pointreel::bench {

double resident_kib(pid_t pid) {
  std::ifstream in(fmt::format("/proc/{}/status", pid));
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("VmRSS:")) return std::stod(line.substr(6));
  }
  return 0.0;
}

double MemoryGrowth::slope(double unit) const {
  if (samples_.empty()) return 0.0;
  const double from = 0.7 * samples_.back().progress;
  double n = 0.0, x = 0.0, y = 0.0;
  for (const Sample& sample : samples_) {
    if (sample.progress < from) continue;
    n += 1.0;
    x += sample.progress;
    y += sample.kib;
  }
  x /= n;
  y /= n;
  double xy = 0.0, xx = 0.0;
  for (const Sample& sample : samples_) {
    if (sample.progress < from) continue;
    xy += (sample.progress - x) * (sample.kib - y);
    xx += (sample.progress - x) * (sample.progress - x);
  }
  return xx > 0.0 ? unit * xy / xx : 0.0;
}

}  // namespace pointreel::bench
