#pragma once

#include <optional>

#include "codec/package/coarsening.h"

/// How a segment must be encoded to meet a bit rate. Pure logic: it says what to encode next, is
/// told how large the result was, and makes its choice after a few trials.
namespace pointreel {

/// Chooses the smallest coarsening whose size is within a budget. First it finds the depth: it
/// takes away as few levels as it can, such that the budget can be met with the coarsest attributes
/// allowed at that depth (most_quality_lost). Then it finds the finest attributes at that depth. It
/// assumes that the size falls if either number rises and that a level quarters it, and it is
/// content with 95 % of the budget.
class RateControl {
 public:
  /// `budget` is in bytes. `attributes` says whether there are any that depend on a quality.
  RateControl(double budget, bool attributes) : budget_(budget), attributes_(attributes) {}

  /// What to encode next; nothing once the choice is made.
  std::optional<Coarsening> next() const { return next_; }
  /// The result of encoding with `next()`: its bytes, and the depth of its deepest frame.
  void told(double bytes, int depth);

  /// The choice, once `next()` gives nothing. The coarsest of all if nothing meets the budget.
  const Coarsening& choice() const { return choice_; }
  bool within_budget() const { return within_budget_; }
  /// The depth of the deepest frame without any coarsening; known after the first trial.
  int finest() const { return finest_; }
  int trials() const { return trials_; }

  /// Trials may encode only some of the frames. If all frames together exceeded the budget with the
  /// choice and took `bytes`, this resumes with something coarser. False if there is nothing.
  bool overshot(double bytes);

 private:
  enum class Phase { asked, levels, quality };

  int max_levels() const;
  Coarsening coarse_at(int levels) const;
  void seek_levels(double bytes);
  void seek_quality();
  void settle(const Coarsening& choice, double bytes, bool within_budget);

  double budget_;
  bool attributes_;
  Phase phase_ = Phase::asked;
  std::optional<Coarsening> next_ = Coarsening{};
  Coarsening choice_;
  double choice_bytes_ = 0.0;
  bool within_budget_ = false;
  int finest_ = 0, trials_ = 0;
  /// Coarsening::levels: the largest number known to be too small, the smallest known to suffice.
  int levels_too_few_ = -1;
  std::optional<int> levels_enough_;
  /// The same for Coarsening::quality, at the depth that was found.
  int quality_too_little_ = -1, quality_enough_ = 0;
  double enough_bytes_ = 0.0;
};

}  // namespace pointreel
