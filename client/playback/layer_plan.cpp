#include "client/playback/layer_plan.h"

#include <chrono>
#include <utility>

#include "client/playback/reel_layers.h"

namespace pointreel {

LayerPlan::LayerPlan(const Manifest& manifest, unsigned threads, bool link)
    : manifest_(manifest),
      control_(control_options(manifest, threads, link)),
      link_cap_(control_.caps().link) {}

LayerDecision LayerPlan::wanted(const PrepareOptions& options) const {
  return wanted_layers(manifest_, options);
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

bool LayerPlan::set_caps(LayerCaps caps) {
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
