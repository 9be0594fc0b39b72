#include "client/playback/layer_control.h"

#include <algorithm>
#include <cmath>

namespace pointreel {
namespace {

// The link.
constexpr double kUse = 0.9;   // share of the link's rate that may be used
constexpr double kFull = 0.9;  // share of the buffer at which it will not run empty
constexpr double kLow = 0.35;  // share of the buffer below which no more is asked of the link
constexpr double kSampleSeconds = 0.04, kSampleBytes = 128 * 1024;
constexpr double kSampleAge = 0.25;     // seconds after which a smaller sample is taken
constexpr double kLeastSeconds = 1e-4;  // bytes that come in one piece take no measurable time
constexpr double kMemory = 0.25;        // seconds of receiving after which half is forgotten
constexpr double kFirstPatience = 1.0, kLongestPatience = 32.0;  // seconds
constexpr double kTrial = 4.0;  // seconds in which a rung on trial may fail
// The machine.
constexpr double kLate = 0.35;  // share of ready frames below which they are late
constexpr double kLateSeconds = 0.3;
constexpr double kSettle = 1.0;             // seconds between two changes
constexpr double kBusy = 0.8, kIdle = 0.7;  // shares of the time available

}  // namespace

const char* name(Limit limit) {
  switch (limit) {
    case Limit::none:
      return "nothing";
    case Limit::asked:
      return "asked";
    case Limit::view:
      return "view";
    case Limit::link:
      return "link";
    case Limit::machine:
      return "machine";
  }
  return "";
}

LayerRange rung_layers(Rung rung, const LayerRange& top) {
  LayerRange layers = top;
  layers.end = std::min(top.end, static_cast<std::uint32_t>(std::max(1, rung)));
  if (rung < kBaseRung && layers.colors) layers.normals = false;
  return layers;
}

LayerDecision decide(const LayerCaps& caps, const LayerRange& top, Limit limit) {
  LayerDecision decision{top, limit};
  if (const LayerRange layers = rung_layers(caps.link, top); layers != top)
    decision = {layers, Limit::link};
  if (caps.machine_layers < decision.layers.end) {
    decision.layers.end = caps.machine_layers;
    decision.limit = Limit::machine;
  }
  return decision;
}

LayerControl::LayerControl(const Options& options)
    : options_(options),
      top_(kBaseRung + static_cast<Rung>(std::max(1u, options.layers)) - 1),
      patience_(kFirstPatience, kLongestPatience),
      machine_layers_(std::max(1u, options.layers)),
      made_ms_(machine_layers_ + 1, 0.0),
      machine_patience_(kSettle, kLongestPatience) {
  if (!options_.link) rung_ = top_;
}

void LayerControl::carried(std::uint64_t bytes, double seconds) {
  sample_bytes_ += static_cast<double>(bytes);
  sample_seconds_ += seconds;
  if (sample_seconds_ >= kSampleSeconds || sample_bytes_ >= kSampleBytes) end_sample();
}

void LayerControl::end_sample() {
  const double rate = sample_bytes_ / std::max(sample_seconds_, kLeastSeconds);
  double kept = std::exp2(-std::max(sample_seconds_, kSampleSeconds) / kMemory);
  // A link that is not busy seems slower than it is, but hardly ever faster.
  if (rate > rate_) kept = std::min(kept, 0.5);
  rate_ = rate_ <= 0.0 ? rate : kept * rate_ + (1.0 - kept) * rate;
  sample_bytes_ = sample_seconds_ = 0.0;
  sampled_ = now_;
}

void LayerControl::made(std::uint32_t layers, double ms) {
  if (layers >= made_ms_.size()) return;
  double& mean = made_ms_[layers];
  mean = mean <= 0.0 ? ms : 0.8 * mean + 0.2 * ms;
}

void LayerControl::forget_made() {
  std::fill(made_ms_.begin(), made_ms_.end(), 0.0);
  late_since_ = -1.0;
}

void LayerControl::update(const Situation& situation) {
  playing_ = situation.playing;
  now_ = situation.now;
  if (sample_bytes_ > 0.0 && now_ - sampled_ >= kSampleAge) end_sample();
  if (!playing_ || situation.bytes.size() <= static_cast<std::size_t>(top_)) {
    late_since_ = -1.0;
    return;
  }
  if (options_.link) update_link(situation);
  if (options_.machine) update_machine(situation);
}

void LayerControl::set_rung(Rung rung, double now) {
  rung_ = std::clamp(rung, kBareRung, top_);
  changed_ = now;
}

void LayerControl::update_link(const Situation& situation) {
  const auto needs = [&](Rung rung) {
    return situation.bytes[static_cast<std::size_t>(rung)] / situation.frame_seconds;
  };
  Rung carried = rate_ > 0.0 ? kBareRung : rung_;
  while (rate_ > 0.0 && carried < top_ && needs(carried + 1) <= kUse * rate_) ++carried;
  const double now = situation.now;
  if (carried < rung_) {
    // A full buffer shows that the link carries this rung after all. With a fuller buffer than
    // kLow, the measured rate may err by the share that is not used.
    const bool kept =
        situation.fetched >= kFull || (situation.fetched >= kLow && needs(rung_) <= rate_);
    if (!kept) {
      if (tried_ >= 0.0 && now - tried_ < kTrial) patience_.failed();
      tried_ = -1.0;
      set_rung(carried, now);
      return;
    }
  } else if (carried > rung_ && situation.fetched >= kLow) {
    set_rung(carried, now);
    return;
  }
  if (tried_ >= 0.0 && now - tried_ >= kTrial) {
    tried_ = -1.0;
    patience_.succeeded();
  }
  if (situation.fetched < kFull) {
    changed_ = std::max(changed_, now - 0.5 * patience_.wait());
  } else if (rung_ < top_ && now - changed_ >= patience_.wait()) {
    tried_ = now;
    set_rung(rung_ + 1, now);
  }
}

void LayerControl::update_machine(const Situation& situation) {
  const auto layers =
      std::min<std::uint32_t>(machine_layers_, static_cast<std::uint32_t>(std::max(1, rung_)));
  const double ms = made_ms_[layers];
  if (ms <= 0.0) return;
  const double budget = 1000.0 * situation.frame_seconds * options_.threads;
  const double now = situation.now;
  const bool late = situation.made < kLate && situation.makeable >= kFull;
  if (!late)
    late_since_ = -1.0;
  else if (late_since_ < 0.0)
    late_since_ = now;
  if (now - machine_changed_ < kSettle) return;
  if (taken_back_ >= 0.0 && now - taken_back_ >= kTrial) {
    taken_back_ = -1.0;
    machine_patience_.succeeded();
  }
  if (late && now - late_since_ >= kLateSeconds && ms > kBusy * budget && layers > 1) {
    if (taken_back_ >= 0.0) machine_patience_.failed();
    taken_back_ = -1.0;
    machine_layers_ = layers - 1;
    machine_changed_ = now;
    late_since_ = -1.0;
    return;
  }
  if (late || machine_layers_ >= options_.layers || layers < machine_layers_ ||
      now - machine_changed_ < machine_patience_.wait())
    return;
  const auto bytes = [&](std::uint32_t count) {
    return situation.bytes[static_cast<std::size_t>(kBaseRung) + count - 1];
  };
  const double more = ms * bytes(layers + 1) / std::max(1.0, bytes(layers));
  if (situation.made >= kFull && more <= kIdle * budget) {
    ++machine_layers_;
    machine_changed_ = taken_back_ = now;
  }
}

}  // namespace pointreel
