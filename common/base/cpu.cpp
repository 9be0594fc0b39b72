#include "pointreel/cpu.h"

#include <atomic>

namespace pointreel {
namespace {

std::atomic<std::uint32_t> allowed{~0u};

std::uint32_t detect() {
#if defined(__x86_64__)
  return (__builtin_cpu_supports("bmi2") ? kCpuBmi2 : 0u) |
         (__builtin_cpu_supports("avx2") ? kCpuAvx2 : 0u);
#else
  return 0;
#endif
}

}  // namespace

void set_cpu_feature_mask(std::uint32_t mask) { allowed.store(mask, std::memory_order_relaxed); }

std::uint32_t cpu_features() {
  static const std::uint32_t detected = detect();
  return detected & allowed.load(std::memory_order_relaxed);
}

}  // namespace pointreel
