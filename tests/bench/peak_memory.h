#pragma once

#include <functional>

namespace pointreel::bench {

/// Memory in MiB that `work` makes this process take at its peak beyond what it held before; 0
/// where the system does not tell (Linux does).
double peak_mib(const std::function<void()>& work);

}  // namespace pointreel::bench
