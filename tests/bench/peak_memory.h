#pragma once

#include <functional>

namespace pointreel::bench {

/// The peak memory in MiB of this process while `work` runs, minus what it held before. 0 if the
/// system does not report it (Linux does).
double peak_mib(const std::function<void()>& work);

}  // namespace pointreel::bench
