#include "client/playback/reel_layers.h"

#include <algorithm>
#include <cstddef>

#include "client/prepare/layer_choice.h"
#include "codec/octree/octree_codec.h"
#include "pointreel/chunks.h"
#include "pointreel/octree.h"

namespace pointreel {

std::vector<int> levels_of(const Manifest& manifest) {
  if (manifest.codec == "video") return {kVideoBaseLevel, kWholeFrame};
  if (manifest.codec != "octree") return {kWholeFrame};
  const int depth = std::min(static_cast<int>(manifest.depth_max), kMaxDepth);
  std::vector<int> levels;
  for (int layer = 0; layer + 1 < layer_count(depth); ++layer)
    levels.push_back(last_level_of_layer(layer, depth));
  if (!manifest.scalars.empty()) levels.push_back(kWholeFrame - 1);
  levels.push_back(kWholeFrame);
  return levels;
}

LayerControl::Options control_options(const Manifest& manifest, unsigned threads, bool link) {
  LayerControl::Options options;
  options.layers = static_cast<std::uint32_t>(levels_of(manifest).size());
  options.threads = threads;
  options.link = link;
  // The octree below a video is so coarse that fewer pictures a second look better.
  options.machine = manifest.codec != "video";
  return options;
}

LayerDecision wanted_layers(const Manifest& manifest, const PrepareOptions& options) {
  LayerDecision decision{layer_choice(manifest, options.mode, options.level, options.show_normals,
                                      !options.scalar.field.empty())};
  const auto all =
      static_cast<std::uint32_t>(std::max<std::size_t>(1, manifest.layer_names.size()));
  std::uint32_t& end = decision.layers.end;
  end = std::min(end, all);
  if (end < all) decision.limit = Limit::view;
  if (options.layers < end) {
    end = options.layers;
    decision.limit = Limit::asked;
  }
  return decision;
}

std::vector<double> rung_bytes(const Manifest& manifest, std::uint32_t index,
                               const LayerRange& most) {
  const Segment& segment = manifest.segments[index];
  std::vector<double> bytes;
  if (segment.layers.empty()) return bytes;
  const auto mean = [&](const LayerRange& layers) {
    std::uint64_t sum = 0;
    for (std::size_t layer = 0; layer < std::min(layers.end, most.end); ++layer)
      for (const Chunks<std::uint32_t>& sizes : segment.layers[layer].frames)
        sum += sizes.geometry + std::uint64_t{layers.colors || layers.normals ? sizes.colors : 0} +
               (layers.normals ? sizes.normals : 0);
    return static_cast<double>(sum) / segment.frame_count();
  };
  LayerRange all = most;
  all.end = static_cast<std::uint32_t>(segment.layers.size());
  for (Rung rung = kBareRung; rung < kBaseRung + static_cast<Rung>(all.end); ++rung)
    bytes.push_back(mean(rung_layers(rung, all)));
  return bytes;
}

}  // namespace pointreel
