#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "client/source/source.h"

namespace pointreel {

/// What keeps a frame from being fetched whole.
enum class Limit { none, asked, view, link, machine };
/// "nothing", "asked", "view", "link", "machine".
const char* name(Limit limit);

/// What is fetched of a segment's frames, and why no more.
struct LayerDecision {
  LayerRange layers;  ///< from the base on
  Limit limit = Limit::none;

  bool operator==(const LayerDecision&) const = default;
};

/// Steps from the least that is shown of a reel to all of it: the base without normals, which can
/// be estimated, the base with all that the mode draws, and from then on one layer more each.
using Rung = int;
inline constexpr Rung kBareRung = 0, kBaseRung = 1;
/// What a rung holds of `top`, the most that the view and the mode need.
LayerRange rung_layers(Rung rung, const LayerRange& top);

/// The most that the link and the machine allow.
struct LayerCaps {
  Rung link = 1 << 8;
  std::uint32_t machine_layers = 1u << 8;

  bool operator==(const LayerCaps&) const = default;
};
/// Of `top`, which is as little as it is because of `limit`.
LayerDecision decide(const LayerCaps& caps, const LayerRange& top, Limit limit);

/// Chooses how much of each frame to fetch, by what the link carries and by what the machine makes
/// ready in time. A plain value without a clock: it is told what happened and what time it is.
///
/// The link. What it carries is measured while it carries anything. A rung is kept up if the link
/// carries nine tenths of what it needs; what is too much is given up as soon as the buffer of
/// fetched frames is no longer full, whatever has been measured. While the buffer stays full, one
/// rung more is tried even if too little has been measured, since a link that is not busy cannot be
/// measured: after a second at first, and after twice as long whenever trying failed.
///
/// The machine. If frames have been fetched but are not ready in time, and making them takes the
/// time of a frame and more, a layer is given up; it is taken back when frames are ready in time
/// and would be with it, going by the bytes: after a second at first, and after twice as long
/// whenever that failed.
class LayerControl {
 public:
  struct Options {
    std::uint32_t layers = 1;  ///< of the reel
    unsigned threads = 2;      ///< that make frames
    bool link = true;          ///< there is one; else only the machine limits
  };

  /// How things stand.
  struct Situation {
    double now = 0.0;            ///< seconds from any start; must not decrease
    bool playing = true;         ///< else there is time for everything
    double frame_seconds = 0.0;  ///< between two frames, at the speed of now; > 0
    double fetched = 0.0;        ///< of the buffer of fetched frames, 0 to 1
    double makeable = 0.0;       ///< of the frames that should be ready, those fetched, 0 to 1
    double made = 0.0;           ///< and those that are ready
    /// Mean bytes of a frame that would be fetched next, of each rung up to that of all layers.
    std::vector<double> bytes;
  };

  explicit LayerControl(const Options& options);

  /// So much came in so many seconds in which the link carried anything, since this was last told.
  void carried(std::uint64_t bytes, double seconds);
  /// A frame was made ready of so many layers.
  void made(std::uint32_t layers, double ms);
  /// What was told of making says nothing about frames from now on.
  void forget_made();

  /// Reconsiders. Call it a few times in the time of a segment.
  void update(const Situation& situation);

  /// None while there is time for everything.
  LayerCaps caps() const { return playing_ ? LayerCaps{rung_, machine_layers_} : LayerCaps{}; }

  double bytes_per_second() const { return rate_; }  ///< of the link; 0: not known yet
  Rung rung() const { return rung_; }
  std::uint32_t machine_layers() const { return machine_layers_; }

 private:
  void update_link(const Situation& situation);
  void update_machine(const Situation& situation);
  void set_rung(Rung rung, double now);
  void end_sample();

  Options options_;
  Rung top_ = kBaseRung;  ///< of all layers
  // The link.
  double rate_ = 0.0;
  double sample_bytes_ = 0.0, sample_seconds_ = 0.0;
  double now_ = 0.0, sampled_ = 0.0;
  Rung rung_ = kBaseRung;
  double changed_ = 0.0;   ///< when rung_ last did
  double tried_ = -1.0;    ///< when a rung was last tried on suspicion; -1: not since
  double patience_ = 1.0;  ///< seconds of a full buffer before one is tried
  bool playing_ = true;
  // The machine.
  std::uint32_t machine_layers_ = 1;
  std::vector<double> made_ms_;  ///< mean of each count of layers; 0: none was made
  double late_since_ = -1.0;     ///< -1: frames are ready in time
  double machine_changed_ = 0.0;
  double taken_back_ = -1.0;       ///< when a layer last was, if that may still fail
  double machine_patience_ = 1.0;  ///< seconds before one is taken back
};

}  // namespace pointreel
