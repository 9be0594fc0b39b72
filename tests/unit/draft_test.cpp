#include "client/render/draft.h"

#include <cstddef>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace pointreel {
namespace {

constexpr int kCoarsest = 1 << Draft::kCoarsest;
constexpr std::uint64_t kMany = 1'000'000;
constexpr Haste kNobody{}, kHand{Haste::Of::hand}, kClock{Haste::Of::clock, 1000.0 / 30};

TEST(Draft, is_used_only_while_somebody_waits_for_the_picture) {
  Draft draft;
  EXPECT_EQ(draft.reduction(kNobody, kMany), 1);
  draft.drew(kMany, 1000.0);
  EXPECT_EQ(draft.reduction(kNobody, kMany), 1);
}

TEST(Draft, is_half_for_the_first_picture) {
  Draft draft;
  EXPECT_EQ(draft.reduction(kHand, 10), 2);
  draft.drew(10, 0.1);
  draft.reduction(kNobody, 10);
  draft.drew(10, 1.0);
  EXPECT_EQ(draft.reduction(kHand, 10), 1) << "whole pictures are fast enough";
  draft = {};
  EXPECT_EQ(draft.reduction(kHand, 10), 2);
}

TEST(Draft, is_as_fine_as_the_available_time_permits) {
  int before = 1;
  for (const double ms : {1.0, 10.0, 40.0, 500.0}) {
    Draft draft;
    draft.reduction(kNobody, kMany);
    draft.drew(kMany, ms);
    const int reduction = draft.reduction(kHand, kMany);
    EXPECT_GE(reduction, before) << ms;
    before = reduction;
  }
  EXPECT_EQ(before, kCoarsest);
}

TEST(Draft, is_finer_if_there_are_few_elements) {
  Draft draft;
  draft.reduction(kNobody, kMany);
  draft.drew(kMany, 500.0);
  EXPECT_EQ(draft.reduction(kHand, kMany / 100), 1);
}

TEST(Draft, never_becomes_finer_while_the_hand_still_moves) {
  Draft draft;
  draft.reduction(kNobody, kMany);
  draft.drew(kMany, 20.0);
  EXPECT_EQ(draft.reduction(kHand, kMany), 2);
  draft.drew(kMany, 100.0);
  EXPECT_EQ(draft.reduction(kHand, kMany), kCoarsest);
  draft.drew(kMany, 0.01);
  EXPECT_EQ(draft.reduction(kHand, kMany), kCoarsest);
  draft.drew(kMany, 0.01);
  EXPECT_EQ(draft.reduction(kNobody, kMany), 1);
  EXPECT_EQ(draft.reduction(kHand, kMany), 1);
}

/// A machine that draws whole pictures in a given number of ms, and smaller ones in proportion.
class PlayingDraft : public testing::Test {
 protected:
  /// Draws the given number of pictures in a row while the clock waits for them. Returns their
  /// reductions.
  std::vector<int> play(int pictures, double whole_ms) {
    std::vector<int> all;
    for (int i = 0; i < pictures; ++i) all.push_back(draw(kClock, whole_ms));
    return all;
  }
  int draw(const Haste& haste, double whole_ms) {
    const int reduction = draft_.reduction(haste, kMany);
    draft_.drew(kMany, whole_ms / (reduction * reduction));
    return reduction;
  }
  static int changes(const std::vector<int>& reductions) {
    int count = 0;
    for (std::size_t i = 1; i < reductions.size(); ++i) count += reductions[i] != reductions[i - 1];
    return count;
  }

  Draft draft_;
};

TEST_F(PlayingDraft, is_whole_if_there_is_time) {
  draw(kHand, 20.0);
  EXPECT_EQ(play(100, 20.0), std::vector<int>(100, 1));
}

TEST_F(PlayingDraft, soon_becomes_whole_if_only_the_first_picture_took_long) {
  draw(kHand, 16 * 40.0);
  const std::vector<int> reductions = play(100, 10.0);
  EXPECT_EQ(reductions.back(), 1);
  EXPECT_LE(changes(reductions), 2);
}

TEST_F(PlayingDraft, is_half_at_once_and_a_quarter_soon_if_the_last_picture_took_much_too_long) {
  draw(kNobody, 60.0);
  draw(kNobody, 60.0);
  EXPECT_EQ(play(200, 60.0), std::vector<int>(200, 2));
  draw(kNobody, 400.0);
  const std::vector<int> reductions = play(200, 400.0);
  EXPECT_EQ(reductions.front(), 2);
  EXPECT_EQ(reductions[3], kCoarsest);
  EXPECT_EQ(changes(reductions), 1);
}

TEST_F(PlayingDraft, does_not_become_coarser_for_a_single_slow_picture) {
  draw(kNobody, 15.0);
  play(20, 15.0);
  play(1, 45.0);
  EXPECT_EQ(play(20, 15.0), std::vector<int>(20, 1));
}

TEST_F(PlayingDraft, becomes_finer_again_after_a_while) {
  draw(kNobody, 15.0);
  play(20, 15.0);
  EXPECT_EQ(play(20, 70.0).back(), 2) << "another program takes processor time";
  const std::vector<int> reductions = play(100, 15.0);
  EXPECT_EQ(reductions[10], 2);
  EXPECT_EQ(reductions.back(), 1);
  EXPECT_EQ(changes(reductions), 1);
}

TEST_F(PlayingDraft, does_not_flicker_if_smaller_pictures_are_faster_than_estimated) {
  // At half of the pixels per side, a picture takes a tenth of the time.
  int changed = 0, before = 1;
  for (int i = 0; i < 2000; ++i) {
    const int reduction = draft_.reduction(kClock, kMany);
    changed += std::exchange(before, reduction) != reduction;
    draft_.drew(kMany, reduction == 1 ? 40.0 : 4.0);
  }
  EXPECT_LE(changed, 16) << "the reduction changed too often in a minute";
}

TEST_F(PlayingDraft, is_whole_when_playback_is_paused) {
  play(10, 400.0);
  EXPECT_EQ(draw(kNobody, 400.0), 1);
}

}  // namespace
}  // namespace pointreel
