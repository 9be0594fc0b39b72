#pragma once

#include <cstdint>

#include "client/scene/draw_stats.h"
#include "client/scene/frame.h"

namespace pointreel {

/// Why a picture is urgent.
struct Haste {
  enum class Of {
    nobody,  ///< it is not
    clock,   ///< frames play, and the next one is due after `frame_ms`
    hand,    ///< the user moves the camera or drags the time, or waits for the first picture
  };
  Of of = Of::nobody;
  double frame_ms = 0.0;
};

/// Decides how much coarser than asked an urgent picture is drawn: with larger elements first,
/// which is hardly seen, then with half and with a quarter of the pixels along each side.
class Draft {
 public:
  /// For the next picture, which has this many elements. To avoid flicker, pictures only become
  /// coarser while a hand moves, and while frames play they become finer only after many pictures
  /// that left enough time.
  DraftCoarsening coarsening(const Haste& haste, std::uint64_t elements);
  /// Reports how long it took to draw this many elements with the last coarsening.
  void drew(std::uint64_t elements, double ms);

 private:
  double share(int level) const;
  int finest_within(double ms) const;
  int level_at_clock(double ms);
  double predicted(int level) const;

  std::uint64_t elements_ = 1;      ///< of the next picture
  double ms_per_element_ = 0.0;     ///< an estimate for level 0
  int drawn_ = 0;                   ///< pictures drawn; stops at two
  int level_ = 0;                   ///< of the last picture; 0 is as asked
  int drawn_level_ = 0;             ///< of the picture before it
  double drawn_per_element_ = 0.0;  ///< its ms
  double larger_share_ = 0.0;       ///< share of level 1 as measured; 0: not known yet
  // While frames play:
  bool at_clock_ = false;
  int late_ = 0;         ///< weighs how many of the last pictures took too long, and by how much
  int in_time_ = 0;      ///< pictures in a row for which the next finer level was fast enough
  int since_finer_ = 0;  ///< pictures since the level last became finer, or many
  int patience_ = 0;     ///< value of in_time_ at which the level becomes finer
};

/// The number of leaves and points that a scene has.
std::uint64_t element_count(const Scene& scene);

}  // namespace pointreel
