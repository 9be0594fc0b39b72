#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "codec/files/read_notes.h"
#include "common/base/concat.h"

/// Colours of floats, and of integers of more than 8 bits. Some writers keep shares of full
/// brightness in them, others numbers of 8 or 16 bits.
namespace pointreel {

/// The number that probably stands for full brightness, by the largest of some colours. Nobody
/// stores 16 bits to keep colours that are all but black. Shares may be a little above 1.
inline double likely_full_color(double largest, bool floats) {
  if (!floats) return largest <= 255.0 ? 255.0 : 65535.0;
  if (largest <= 2.0 || largest > 65535.5) return 1.0;
  return largest < 255.5 ? 255.0 : 65535.0;
}

/// The number that stands for full brightness in colours whose largest is given: that of the notes,
/// or else the likely one. The notes are told, and warn of colours beyond.
inline double choose_full_color(double largest, bool floats, ReadNotes& notes) {
  const double likely = likely_full_color(largest, floats);
  if (notes.full_color == 0.0) notes.full_color = likely;
  notes.odd_colors = notes.full_color != (floats ? 1.0 : 65535.0);
  if (likely > notes.full_color) {
    notes.warnings.push_back(concat("has colours up to ", std::llround(std::min(largest, 1e9)),
                                    ", which are cut off at ", std::llround(notes.full_color),
                                    ", the full brightness; --color-max sets it"));
  }
  const bool shares = floats && notes.full_color > 1.0 && largest > 0.0 && largest <= 1.0;
  const bool bytes = notes.full_color > 255.0 && largest > 127.0 && largest <= 255.0;
  if (shares || bytes) {
    notes.warnings.push_back(concat("has colours from 0 to ", shares ? 1 : std::llround(largest),
                                    ", which are all but black, because ",
                                    std::llround(notes.full_color),
                                    " is the full brightness of the others; --color-max sets it"));
  }
  return notes.full_color;
}

/// A colour in the range from 0 to 65535. It is clamped, and NaN is 0.
inline std::uint16_t color_of(double value, double full) {
  if (!(value > 0.0)) return 0;
  return static_cast<std::uint16_t>(std::min(value / full, 1.0) * 65535.0 + 0.5);
}

}  // namespace pointreel
