#pragma once

#include <optional>

#include "server/rate/coarsening.h"

/// What a bit rate makes of a segment's settings. Pure logic: it says what to encode next, is told
/// how large that became, and comes to its choice in a few trials.
namespace pointreel {

/// Chooses the least coarsening whose size is within a budget: the fewest levels lost for which
/// that can be reached at all, with attributes as coarse as they may be then (most_quality_lost);
/// and at that depth the finest attributes. Takes sizes to fall as either number grows, a level to
/// quarter them, and is content with 95 % of the budget.
class RateControl {
 public:
  /// `budget`: bytes. `attributes`: whether there are any that quality changes.
  RateControl(double budget, bool attributes) : budget_(budget), attributes_(attributes) {}

  /// What to encode next; nothing once the choice is made.
  std::optional<Coarsening> next() const { return next_; }
  /// What `next()` came to: its bytes, and the depth of its deepest frame.
  void told(double bytes, int depth);

  /// The choice, once there is no next. The coarsest of all if nothing is within the budget.
  const Coarsening& choice() const { return choice_; }
  bool within_budget() const { return within_budget_; }
  /// Depth of the deepest frame that was asked for, from the first trial on.
  int finest() const { return finest_; }
  int trials() const { return trials_; }

  /// A trial may be of some of the frames. If all of them came to more than the budget with what
  /// was chosen, to so many `bytes`: goes on with what is coarser. False if nothing is.
  bool overshot(double bytes);

 private:
  enum class Phase { asked, levels, quality };

  int most_levels() const;
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
  /// Levels lost: the most that are known not to be enough, the fewest that are.
  int levels_too_few_ = -1;
  std::optional<int> levels_enough_;
  /// The same of quality, at the depth that was found.
  int quality_too_little_ = -1, quality_enough_ = 0;
  double enough_bytes_ = 0.0;
};

}  // namespace pointreel
