#pragma once

#include <cstdint>

#include "client/scene/frame.h"

namespace pointreel {

/// Who waits for a picture.
struct Haste {
  enum class Of {
    nobody,
    clock,  ///< there is another one after `frame_ms`
    hand,   ///< that moves the camera or the time; or the first one is to be seen
  };
  Of of = Of::nobody;
  double frame_ms = 0.0;
};

/// How much smaller than it is shown to draw a picture that is waited for.
class Draft {
 public:
  static constexpr int kCoarsest = 2;  ///< level, each of half as many pixels a side

  /// The DrawOptions::reduction of the next picture, of so many elements. So that nothing flickers,
  /// it only becomes coarser while a hand moves, and while the clock runs, finer only after many
  /// pictures that left time for it.
  int reduction(const Haste& haste, std::uint64_t elements);
  /// Drawing so many, with the last reduction, took so long.
  void drew(std::uint64_t elements, double ms);

 private:
  int finest_within(double ms) const;
  int level_at_clock(double ms);
  double predicted(int level) const;

  std::uint64_t elements_ = 1;   ///< of the next picture
  double ms_per_element_ = 0.0;  ///< at level 0, roughly
  int drawn_ = 0;                ///< pictures, counted up to the second
  int level_ = 0;                ///< of the last one
  // While the clock runs.
  bool at_clock_ = false;
  int late_ = 0;     ///< how often and how much pictures took too long
  int in_time_ = 0;  ///< pictures in a row, for which a finer level would have done as well
  int since_finer_ = 0;
  int patience_ = 0;  ///< how many of them make it finer
};

/// Leaves and points that could be drawn.
std::uint64_t element_count(const Scene& scene);

}  // namespace pointreel
