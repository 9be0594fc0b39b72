#pragma once

#include <string>
#include <vector>

#include "pointreel/codec.h"
#include "pointreel/draco.h"

namespace pointreel::bench {

/// One way to encode: what the library is told, and what `pointreel-server pack` is told for the
/// same.
struct Setting {
  std::string codec;  ///< a curve of the plots: "octree none", "octree zstd", "draco"
  std::string name;   ///< within it: "depth 10", "qp 11"
  int bits;           ///< of a coordinate: the depth, or Draco's position bits
  bool on_curve;      ///< else it differs in something else, such as effort
  EncodeOptions options;
  std::vector<std::string> pack_arguments;
};

/// Every codec at each of its settings that matter for `max_bits` of a coordinate: depths and
/// position bits from 8 up, and at 10 bits qualities of the octree's colours and Draco's efforts.
std::vector<Setting> report_settings(int max_bits);

}  // namespace pointreel::bench
