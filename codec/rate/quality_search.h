#pragma once

#include <cstdint>

namespace pointreel {

/// Finds the quality at which a segment of video fits into a number of bytes, in few encodes,
/// because each takes seconds. The logarithm of the bytes grows with the quality about evenly.
///
///     do encode(search.quality()); while (!search.accepts(bytes));
class QualitySearch {
 public:
  /// `asked`: the finest quality, 1 to 100. `points`: of all frames, for the first guess.
  QualitySearch(double budget, int asked, std::uint64_t points);

  /// What to try next.
  int quality() const { return quality_; }

  /// Whether what was tried stays: it fits, and not much is left over; or nothing that was not
  /// tried fits better. Otherwise, chooses the next one.
  bool accepts(double bytes);

  bool fits() const { return fits_; }  ///< what was accepted
  int tries() const { return tries_; }

 private:
  void choose();

  double budget_;
  int quality_;
  int tries_ = 0;
  bool fits_ = false;
  int below_ = 0, above_;  ///< the finest that fits, and the coarsest that does not; 0: none
  double below_bytes_ = 0.0, above_bytes_ = 0.0;
};

}  // namespace pointreel
