#include "codec/octree/octree_codec.h"

#include <algorithm>
#include <array>

#include "pointreel/octree.h"

namespace pointreel {
namespace {

constexpr std::array<int, 3> kLayerEnds = {7, 9, kMaxDepth};

}  // namespace

int last_level_of_layer(int layer, int depth) {
  return std::min(depth, kLayerEnds[static_cast<std::size_t>(layer)]);
}

int layer_count(int depth) {
  int layers = 1;
  while (last_level_of_layer(layers - 1, depth) < depth) ++layers;
  return layers;
}

}  // namespace pointreel
