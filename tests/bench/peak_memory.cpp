#include "tests/bench/peak_memory.h"

#include <algorithm>
#include <fstream>
#include <string>

#include <malloc.h>

namespace pointreel::bench {
namespace {

/// A figure from /proc/self/status in MiB; 0 if it is missing.
double status(const std::string& key) {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(key + ":")) return std::stod(line.substr(key.size() + 1)) / 1024.0;
  }
  return 0.0;
}

}  // namespace

double peak_mib(const std::function<void()>& work) {
  malloc_trim(0);  // otherwise `work` could use freed memory that the process still holds
  std::ofstream("/proc/self/clear_refs") << 5;  // resets the peak
  const double before = status("VmRSS");
  work();
  return std::max(status("VmHWM") - before, 0.0);
}

}  // namespace pointreel::bench
