#include "client/render/draft.h"

#include <cstddef>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace pointreel::draft_test {
namespace {

constexpr int kCoarsest = 4;  ///< the largest reduction
constexpr DraftCoarsening kAsAsked{}, kLarger{1, 1.25f}, kHalf{2, 1.0f};
constexpr std::uint64_t kMany = 1'000'000;
constexpr Haste kNobody{}, kHand{Haste::Of::hand}, kClock{Haste::Of::clock, 1000.0 / 30};

TEST(Draft, is_used_only_while_somebody_waits_for_the_picture) {
  Draft draft;
  EXPECT_EQ(draft.coarsening(kNobody, kMany), kAsAsked);
  draft.drew(kMany, 1000.0);
  EXPECT_EQ(draft.coarsening(kNobody, kMany), kAsAsked);
}

TEST(Draft, is_half_for_the_first_picture) {
  Draft draft;
  EXPECT_EQ(draft.coarsening(kHand, 10), kHalf);
  draft.drew(10, 0.1);
  draft.coarsening(kNobody, 10);
  draft.drew(10, 1.0);
  EXPECT_EQ(draft.coarsening(kHand, 10), kAsAsked) << "whole pictures are fast enough";
  draft = {};
  EXPECT_EQ(draft.coarsening(kHand, 10), kHalf);
}

TEST(Draft, is_as_fine_as_the_available_time_permits) {
  int before = 1;
  for (const double ms : {1.0, 10.0, 40.0, 500.0}) {
    Draft draft;
    draft.coarsening(kNobody, kMany);
    draft.drew(kMany, ms);
    const int reduction = draft.coarsening(kHand, kMany).reduction;
    EXPECT_GE(reduction, before) << ms;
    before = reduction;
  }
  EXPECT_EQ(before, kCoarsest);
}

TEST(Draft, is_finer_if_there_are_few_elements) {
  Draft draft;
  draft.coarsening(kNobody, kMany);
  draft.drew(kMany, 500.0);
  EXPECT_EQ(draft.coarsening(kHand, kMany / 100), kAsAsked);
}

TEST(Draft, never_becomes_finer_while_the_hand_still_moves) {
  Draft draft;
  draft.coarsening(kNobody, kMany);
  draft.drew(kMany, 20.0);
  EXPECT_EQ(draft.coarsening(kHand, kMany), kLarger);
  draft.drew(kMany, 100.0);
  EXPECT_EQ(draft.coarsening(kHand, kMany).reduction, kCoarsest);
  draft.drew(kMany, 0.01);
  EXPECT_EQ(draft.coarsening(kHand, kMany).reduction, kCoarsest);
  draft.drew(kMany, 0.01);
  EXPECT_EQ(draft.coarsening(kNobody, kMany), kAsAsked);
  EXPECT_EQ(draft.coarsening(kHand, kMany), kAsAsked);
}

/// A machine that draws whole pictures in a given number of ms, and smaller ones in proportion.
class PlayingDraft : public testing::Test {
 protected:
  /// Draws the given number of pictures in a row while the clock waits for them.
  std::vector<DraftCoarsening> play(int pictures, double whole_ms) {
    std::vector<DraftCoarsening> all;
    for (int i = 0; i < pictures; ++i) all.push_back(draw(kClock, whole_ms));
    return all;
  }
  DraftCoarsening draw(const Haste& haste, double whole_ms) {
    const DraftCoarsening coarsening = draft_.coarsening(haste, kMany);
    const double elements = coarsening.pixel_size > 1.0f ? share_of_larger_ : 1.0;
    draft_.drew(kMany, elements * whole_ms / (coarsening.reduction * coarsening.reduction));
    return coarsening;
  }
  static int changes(const std::vector<DraftCoarsening>& pictures) {
    int count = 0;
    for (std::size_t i = 1; i < pictures.size(); ++i) count += pictures[i] != pictures[i - 1];
    return count;
  }

  double share_of_larger_ = 1.0;  ///< of the time, where larger elements are allowed
  Draft draft_;
};

TEST_F(PlayingDraft, is_whole_if_there_is_time) {
  draw(kHand, 20.0);
  EXPECT_EQ(play(100, 20.0), std::vector<DraftCoarsening>(100, kAsAsked));
}

TEST_F(PlayingDraft, soon_becomes_whole_if_only_the_first_picture_took_long) {
  draw(kHand, 16 * 40.0);
  const std::vector<DraftCoarsening> pictures = play(100, 10.0);
  EXPECT_EQ(pictures.back(), kAsAsked);
  EXPECT_LE(changes(pictures), 2);
}

TEST_F(PlayingDraft, has_larger_elements_and_all_pixels_if_that_suffices) {
  share_of_larger_ = 0.55;
  draw(kNobody, 38.0);
  draw(kNobody, 38.0);
  EXPECT_EQ(play(500, 38.0), std::vector<DraftCoarsening>(500, kLarger));
}

TEST_F(PlayingDraft, has_half_the_pixels_if_larger_elements_do_not_help) {
  draw(kNobody, 38.0);
  draw(kNobody, 38.0);
  const std::vector<DraftCoarsening> pictures = play(500, 38.0);
  EXPECT_EQ(pictures[0], kLarger);
  EXPECT_EQ(pictures[3], kHalf);
  EXPECT_EQ(pictures.back(), kHalf);
  EXPECT_EQ(changes(pictures), 1);
}

TEST_F(PlayingDraft, is_half_at_once_and_a_quarter_soon_if_the_last_picture_took_much_too_long) {
  draw(kNobody, 60.0);
  draw(kNobody, 60.0);
  EXPECT_EQ(play(200, 60.0), std::vector<DraftCoarsening>(200, kHalf));
  draw(kNobody, 400.0);
  const std::vector<DraftCoarsening> pictures = play(200, 400.0);
  EXPECT_EQ(pictures.front(), kHalf);
  EXPECT_EQ(pictures[3].reduction, kCoarsest);
  EXPECT_EQ(changes(pictures), 1);
}

TEST_F(PlayingDraft, does_not_become_coarser_for_a_single_slow_picture) {
  draw(kNobody, 15.0);
  play(20, 15.0);
  play(1, 45.0);
  EXPECT_EQ(play(20, 15.0), std::vector<DraftCoarsening>(20, kAsAsked));
}

TEST_F(PlayingDraft, becomes_finer_again_after_a_while) {
  draw(kNobody, 15.0);
  play(20, 15.0);
  EXPECT_EQ(play(20, 70.0).back(), kHalf) << "another program takes processor time";
  const std::vector<DraftCoarsening> pictures = play(100, 15.0);
  EXPECT_EQ(pictures[10], kHalf);
  EXPECT_EQ(pictures.back(), kAsAsked);
  EXPECT_EQ(changes(pictures), 2);
}

TEST_F(PlayingDraft, does_not_flicker_if_smaller_pictures_are_faster_than_estimated) {
  // At half of the pixels per side, a picture takes a tenth of the time.
  int changed = 0;
  DraftCoarsening before;
  for (int i = 0; i < 2000; ++i) {
    const DraftCoarsening coarsening = draft_.coarsening(kClock, kMany);
    changed += std::exchange(before, coarsening) != coarsening;
    draft_.drew(kMany, coarsening.reduction == 1 ? 40.0 : 4.0);
  }
  EXPECT_LE(changed, 24) << "the coarsening changed too often in a minute";
}

TEST_F(PlayingDraft, is_whole_when_playback_is_paused) {
  play(10, 400.0);
  EXPECT_EQ(draw(kNobody, 400.0), kAsAsked);
}

}  // namespace
}  // namespace pointreel::draft_test
