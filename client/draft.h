#pragma once

#include <cstdint>

#include "client/render/renderer.h"
#include "client/scene/frame.h"

namespace pointreel {

/// How much smaller than it is shown to draw a picture that somebody waits for: the first one, and
/// those of a camera or a time that is moved by hand.
class Draft {
 public:
  static constexpr int kCoarsest = 2;  ///< level, each of half as many pixels a side

  /// The DrawOptions::reduction of the next picture, of so many elements; `hurried`: it is waited
  /// for. From one hurried picture to the next it becomes coarser at most, so that nothing
  /// flickers.
  int reduction(bool hurried, std::uint64_t elements);
  /// Drawing so many, with the last reduction, took so long.
  void drew(std::uint64_t elements, double ms);

 private:
  double ms_per_element_ = -1.0;  ///< at level 0, roughly; < 0: not known
  int level_ = 0;                 ///< of the last one
};

/// Leaves and points that could be drawn.
std::uint64_t element_count(const Scene& scene);

}  // namespace pointreel
