#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "client/playback/clock.h"
#include "client/playback/layer_control.h"
#include "client/prepare/prepare.h"
#include "client/source/source.h"
#include "pointreel/package.h"

namespace pointreel {

/// How much of a reel's frames is fetched: what the mode and the view need, or less if the user
/// asked for less, or if the link or the machine does not keep up (LayerControl). One thread plays;
/// the functions before `update` may be called by any thread.
class LayerPlan {
 public:
  /// The manifest outlives the plan. `threads`: how many make frames. `link`: the reel comes over
  /// one.
  LayerPlan(const Manifest& manifest, unsigned threads, bool link);

  /// Without regard to link and machine, for frames that are prepared for this mode and level.
  LayerDecision wanted(const PrepareOptions& options) const;
  /// With regard to them.
  LayerDecision decide(const PrepareOptions& options) const;
  /// LayerControl's.
  void made(std::uint32_t layers, double ms);
  void forget_made();
  double bytes_per_second() const;

  /// Reconsiders link and machine, given how things stand; `now`, and `bytes` for `next_frame`, are
  /// filled in. True if decide() answers differently from now on.
  bool update(Clock::TimePoint now, LayerControl::Situation situation, const LinkUse& use,
              std::uint32_t next_frame, const PrepareOptions& options);
  /// From now on neither link nor machine matters, until the next update. True as for update().
  bool lift_limits() { return set_caps({}); }

  /// Decisions for the frames from this one to that of the next entry, or to the last one fetched.
  struct Chosen {
    std::uint32_t first_frame = 0;  ///< of a segment
    LayerDecision decision;
  };
  /// Notes what is chosen for the segment of this frame.
  void note(std::uint32_t frame, const PrepareOptions& options);
  /// The last choice noted for each segment; those that follow each other and are alike are one.
  std::vector<Chosen> chosen() const;

 private:
  LayerCaps caps() const { return {link_cap_, machine_cap_}; }
  bool set_caps(LayerCaps caps);

  const Manifest& manifest_;
  mutable std::mutex mutex_;  ///< guards control_
  LayerControl control_;
  std::atomic<Rung> link_cap_;
  std::atomic<std::uint32_t> machine_cap_{LayerCaps{}.machine_layers};
  // Used by the thread that plays.
  std::optional<Clock::TimePoint> first_update_;
  LinkUse link_use_;                               ///< as of the last update
  std::map<std::uint32_t, LayerDecision> chosen_;  ///< by segment
};

}  // namespace pointreel
