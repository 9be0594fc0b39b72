#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "client/source/fetched.h"
#include "common/base/backoff.h"

namespace pointreel {

/// The reason why a frame is not fetched whole.
enum class Limit { none, asked, view, link, machine };
/// "nothing", "asked", "view", "link", "machine".
const char* name(Limit limit);

/// What is fetched of a segment's frames, and why not more.
struct LayerDecision {
  LayerRange layers;  ///< from the base on
  Limit limit = Limit::none;

  bool operator==(const LayerDecision&) const = default;
};

/// Steps from the least that is ever shown of a reel to all of it: the base without normals (they
/// can be estimated), the base with all that the mode draws, and then one more layer for each rung.
using Rung = int;
inline constexpr Rung kBareRung = 0, kBaseRung = 1;
/// The layers that a rung has out of `top`, the most that the view and the mode need.
LayerRange rung_layers(Rung rung, const LayerRange& top);

/// The most that the link and the machine allow.
struct LayerCaps {
  Rung link = 1 << 8;
  std::uint32_t machine_layers = 1u << 8;

  bool operator==(const LayerCaps&) const = default;
};
/// How much of `top` to fetch. `limit` is the reason why `top` itself is not everything.
LayerDecision decide(const LayerCaps& caps, const LayerRange& top, Limit limit);

/// Chooses how much of each frame to fetch, by how much the link carries and by how much the
/// machine makes ready in time. A plain value without a clock: it is told what happened and what
/// time it is.
///
/// The link. Its rate is measured while it carries anything. A rung needs no more than nine tenths
/// of the rate. A rung that needs too much is given up as soon as the buffer of fetched frames is
/// no longer full. While the buffer stays full, the next rung is tried even if the measured rate is
/// too low for it, because a link that is not busy cannot be measured. That is tried after a second
/// at first, and after twice as long whenever it failed.
///
/// The machine. If frames have been fetched but are not ready in time, and making them takes about
/// the time of a frame or more, a layer is given up. It is taken back when frames are ready in time
/// and, judged by the bytes, would be with that layer, too: after a second at first, and after
/// twice as long whenever that failed.
class LayerControl {
 public:
  struct Options {
    std::uint32_t layers = 1;  ///< how many the reel has
    unsigned threads = 2;      ///< how many make frames
    bool link = true;          ///< false for a local reel, which only the machine limits
    bool machine = true;       ///< false if fewer frames are better than frames of fewer layers
  };

  /// How things stand.
  struct Situation {
    double now = 0.0;            ///< seconds from any start; must not decrease
    bool playing = true;         ///< else there is time for everything
    double frame_seconds = 0.0;  ///< between two frames, at the current speed; > 0
    double fetched = 0.0;        ///< how full the buffer of fetched frames is, 0 to 1
    double makeable = 0.0;       ///< the share of frames to be made that have been fetched, 0 to 1
    double made = 0.0;           ///< the share of them that are ready, 0 to 1
    /// For each rung up to that of all layers: the mean size of the frames to be fetched next.
    std::vector<double> bytes;
  };

  explicit LayerControl(const Options& options);

  /// What came since the last call, and for how many seconds the link carried anything.
  void carried(std::uint64_t bytes, double seconds);
  /// A frame was made ready from this many layers, in this time.
  void made(std::uint32_t layers, double ms);
  /// Times of made() do not count for frames from now on.
  void forget_made();

  /// Reconsiders. Call it a few times during each segment.
  void update(const Situation& situation);

  /// No limits while there is time for everything.
  LayerCaps caps() const { return playing_ ? LayerCaps{rung_, machine_layers_} : LayerCaps{}; }

  double bytes_per_second() const { return rate_; }  ///< the link's rate; 0: not known yet
  Rung rung() const { return rung_; }
  std::uint32_t machine_layers() const { return machine_layers_; }

 private:
  void update_link(const Situation& situation);
  void update_machine(const Situation& situation);
  void set_rung(Rung rung, double now);
  void end_sample();

  Options options_;
  Rung top_ = kBaseRung;  ///< the rung with all layers
  // The link.
  double rate_ = 0.0;
  double sample_bytes_ = 0.0, sample_seconds_ = 0.0;
  double now_ = 0.0, sampled_ = 0.0;
  Rung rung_ = kBaseRung;
  double changed_ = 0.0;      ///< when rung_ last changed
  double tried_ = -1.0;       ///< when a rung that may still fail was tried; -1: none is on trial
  Backoff<double> patience_;  ///< seconds of a full buffer before a rung is tried
  bool playing_ = true;
  // The machine.
  std::uint32_t machine_layers_ = 1;
  std::vector<double> made_ms_;  ///< mean time for each number of layers; 0: none was made
  double late_since_ = -1.0;     ///< -1: frames are ready in time
  double machine_changed_ = 0.0;
  double taken_back_ = -1.0;          ///< when a layer that may still fail was taken back, or -1
  Backoff<double> machine_patience_;  ///< seconds before a layer is taken back
};

}  // namespace pointreel
