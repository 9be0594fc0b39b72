#include "client/draft.h"

#include <gtest/gtest.h>

namespace pointreel {
namespace {

constexpr int kCoarsest = 1 << Draft::kCoarsest;
constexpr std::uint64_t kMany = 1'000'000;

TEST(Draft, IsOnlyOfWhatIsWaitedFor) {
  Draft draft;
  EXPECT_EQ(draft.reduction(false, kMany), 1);
  draft.drew(kMany, 1000.0);
  EXPECT_EQ(draft.reduction(false, kMany), 1);
}

TEST(Draft, OfTheFirstPictureIsTheCoarsest) {
  Draft draft;
  EXPECT_EQ(draft.reduction(true, 10), kCoarsest);
  draft.drew(10, 0.1);
  draft.reduction(false, 10);
  draft.drew(10, 1.0);
  EXPECT_EQ(draft.reduction(true, 10), 1) << "it is quick enough as it is";
  draft = {};
  EXPECT_EQ(draft.reduction(true, 10), kCoarsest);
}

TEST(Draft, IsAsFineAsThereIsTimeFor) {
  int before = 1;
  for (const double ms : {1.0, 10.0, 40.0, 500.0}) {
    Draft draft;
    draft.reduction(false, kMany);
    draft.drew(kMany, ms);
    const int reduction = draft.reduction(true, kMany);
    EXPECT_GE(reduction, before) << ms;
    before = reduction;
  }
  EXPECT_EQ(before, kCoarsest);
}

TEST(Draft, OfFewElementsIsFiner) {
  Draft draft;
  draft.reduction(false, kMany);
  draft.drew(kMany, 500.0);
  EXPECT_EQ(draft.reduction(true, kMany / 100), 1);
}

TEST(Draft, BecomesCoarserAtMostUntilNobodyWaits) {
  Draft draft;
  draft.reduction(false, kMany);
  draft.drew(kMany, 20.0);
  EXPECT_EQ(draft.reduction(true, kMany), 2);
  draft.drew(kMany, 100.0);
  EXPECT_EQ(draft.reduction(true, kMany), kCoarsest);
  draft.drew(kMany, 0.01);
  EXPECT_EQ(draft.reduction(true, kMany), kCoarsest);
  draft.drew(kMany, 0.01);
  EXPECT_EQ(draft.reduction(false, kMany), 1);
  EXPECT_EQ(draft.reduction(true, kMany), 1);
}

}  // namespace
}  // namespace pointreel
