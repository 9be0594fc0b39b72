#pragma once

#include "pointreel/cpu.h"

namespace pointreel {

/// During its lifetime, the codec runs its portable code, as on a processor without extensions.
class PortableCode {
 public:
  PortableCode() { set_cpu_feature_mask(0); }
  ~PortableCode() { set_cpu_feature_mask(~0u); }
  PortableCode(const PortableCode&) = delete;
  PortableCode& operator=(const PortableCode&) = delete;
};

}  // namespace pointreel
