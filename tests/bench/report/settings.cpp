#include "tests/bench/report/settings.h"

#include <algorithm>

#include <fmt/format.h>

#include "pointreel/draco.h"

namespace pointreel::bench {
namespace {

constexpr int kLeastBits = 8;
constexpr int kEffortBits = 10;

Setting octree(Entropy entropy, int depth, int quality) {
  const bool is_default = quality == kDefaultColorQuality;
  OctreeOptions options;
  options.entropy = entropy;
  options.depth = DepthRule::fixed(depth);
  options.color_quality = quality;
  return {fmt::format("octree {}", name(entropy)),
          is_default ? fmt::format("depth {}", depth)
                     : fmt::format("depth {}, quality {}", depth, quality),
          depth,
          is_default,
          {options},
          {"--codec", "octree", "--entropy", name(entropy), "--depth", std::to_string(depth),
           "--quality", std::to_string(quality)}};
}

Setting draco(int bits, int level, bool on_curve) {
  DracoOptions options;
  options.position_bits = bits;
  options.compression_level = level;
  return {
      "draco",   on_curve ? fmt::format("qp {}", bits) : fmt::format("qp {}, cl {}", bits, level),
      bits,      on_curve,
      {options}, {"--codec", "draco", "--qp", std::to_string(bits), "--cl", std::to_string(level)}};
}

}  // namespace

std::vector<Setting> report_settings(int max_bits) {
  std::vector<Setting> settings;
  for (const Entropy entropy : {Entropy::none, Entropy::zstd, Entropy::context}) {
    for (int depth = kLeastBits; depth <= max_bits; ++depth) {
      settings.push_back(octree(entropy, depth, kDefaultColorQuality));
    }
  }
  for (const int quality : {20, 35, 65, 80, kLosslessColorQuality}) {
    settings.push_back(octree(Entropy::context, std::min(kEffortBits, max_bits), quality));
  }
  for (int bits = kLeastBits; bits <= max_bits; ++bits) {
    settings.push_back(draco(bits, DracoOptions{}.compression_level, true));
  }
  for (const int level : {0, 10}) {
    settings.push_back(draco(std::min(kEffortBits, max_bits), level, false));
  }
  return settings;
}

}  // namespace pointreel::bench
