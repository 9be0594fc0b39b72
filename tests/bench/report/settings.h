#pragma once

#include <string>
#include <vector>

#include "pointreel/codec.h"
#include "pointreel/draco.h"

namespace pointreel::bench {

/// One way to encode.
struct Setting {
  std::string codec;  ///< a curve of the plots: "octree none", "octree zstd", "draco"
  std::string name;   ///< a point of the curve: "depth 10", "qp 11"
  int bits;           ///< per coordinate: the depth, or Draco's position bits
  bool on_curve;      ///< false for a setting that differs in more than its bits, such as effort
  EncodeOptions options;
  std::vector<std::string> pack_arguments;  ///< the same options for `pointreel-server pack`
};

/// The settings of every codec that matter for up to `max_bits` per coordinate: depths and position
/// bits from 8 up, and, at 10 bits, colour qualities of the octree and compression levels of Draco.
std::vector<Setting> report_settings(int max_bits);

}  // namespace pointreel::bench
