#include "client/playback/layer_plan.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "client/prepare/layer_choice.h"
#include "codec/octree/octree_codec.h"
#include "pointreel/chunks.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

/// LayerControl::Situation::bytes of a segment, with the attributes of `most`; empty for files.
std::vector<double> rung_bytes(const Manifest& manifest, std::uint32_t index,
                               const LayerRange& most) {
  const Segment& segment = manifest.segments[index];
  std::vector<double> bytes;
  if (segment.layers.empty()) return bytes;
  const auto mean = [&](const LayerRange& layers) {
    std::uint64_t sum = 0;
    for (std::size_t layer = 0; layer < layers.end; ++layer)
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

}  // namespace

std::vector<int> levels_of(const Manifest& manifest) {
  if (manifest.codec != "octree") return {kWholeFrame};
  const int depth = std::min(static_cast<int>(manifest.depth_max), kMaxDepth);
  std::vector<int> levels;
  for (int layer = 0; layer + 1 < layer_count(depth); ++layer)
    levels.push_back(last_level_of_layer(layer, depth));
  levels.push_back(kWholeFrame);
  return levels;
}

LayerPlan::LayerPlan(const Manifest& manifest, unsigned threads, bool link)
    : manifest_(manifest),
      control_({static_cast<std::uint32_t>(levels_of(manifest).size()), threads, link}),
      link_cap_(control_.caps().link) {}

LayerDecision LayerPlan::wanted(const PrepareOptions& options) const {
  LayerDecision decision{
      layer_choice(manifest_, options.mode, options.level, options.show_normals)};
  const auto all =
      static_cast<std::uint32_t>(std::max<std::size_t>(1, manifest_.layer_names.size()));
  std::uint32_t& end = decision.layers.end;
  end = std::min(end, all);
  if (end < all) decision.limit = Limit::view;
  if (options.layers < end) {
    end = options.layers;
    decision.limit = Limit::asked;
  }
  return decision;
}

LayerDecision LayerPlan::decide(const PrepareOptions& options) const {
  const LayerDecision most = wanted(options);
  return pointreel::decide(caps(), most.layers, most.limit);
}

void LayerPlan::made(std::uint32_t layers, double ms) {
  const std::lock_guard lock(mutex_);
  control_.made(layers, ms);
}

void LayerPlan::forget_made() {
  const std::lock_guard lock(mutex_);
  control_.forget_made();
}

double LayerPlan::bytes_per_second() const {
  const std::lock_guard lock(mutex_);
  return control_.bytes_per_second();
}

bool LayerPlan::update(Clock::TimePoint now, LayerControl::Situation situation, const LinkUse& use,
                       std::uint32_t next_frame, const PrepareOptions& options) {
  if (!first_update_) first_update_ = now;
  situation.now = std::chrono::duration<double>(now - *first_update_).count();
  PrepareOptions finest = options;
  finest.level = kWholeFrame;
  situation.bytes =
      rung_bytes(manifest_, locate(manifest_, next_frame).segment, wanted(finest).layers);
  const LinkUse before = std::exchange(link_use_, use);
  LayerCaps caps;
  {
    const std::lock_guard lock(mutex_);
    control_.carried(use.bytes - before.bytes,
                     std::chrono::duration<double>(use.receiving - before.receiving).count());
    control_.update(situation);
    caps = control_.caps();
  }
  return set_caps(caps);
}

bool LayerPlan::set_caps(const LayerCaps& caps) {
  if (caps == this->caps()) return false;
  link_cap_ = caps.link;
  machine_cap_ = caps.machine_layers;
  return true;
}

void LayerPlan::note(std::uint32_t frame, const PrepareOptions& options) {
  chosen_.insert_or_assign(locate(manifest_, frame).segment, decide(options));
}

std::vector<LayerPlan::Chosen> LayerPlan::chosen() const {
  std::vector<Chosen> runs;
  std::uint32_t next = 0;
  for (const auto& [segment, decision] : chosen_) {
    if (runs.empty() || segment != next || runs.back().decision != decision)
      runs.push_back({manifest_.segments[segment].first_frame, decision});
    next = segment + 1;
  }
  return runs;
}

}  // namespace pointreel
