#include "codec/files/file_numbers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pointreel::file_numbers_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

using Names = std::vector<std::string>;

TEST(FileNumbers, missing_numbers_are_named_and_leave_gaps) {
  const Names names{"scan2_8.ply", "scan2_9.ply", "Scan2_011.ply", "scan2_12.ply", "scan2_20.ply"};
  EXPECT_EQ(missing_numbers(names), "10, 13 to 19");
  EXPECT_THAT(places_by_number(names), ElementsAre(0, 1, 3, 4, 12));
}

TEST(FileNumbers, every_tenth_frame_lacks_none) {
  const Names names{"0.ply", "10.ply", "20.ply", "30.ply"};
  EXPECT_EQ(missing_numbers(names), "");
  EXPECT_THAT(places_by_number(names), ElementsAre(0, 1, 2, 3));
}

TEST(FileNumbers, names_that_do_not_count_lack_nothing) {
  for (const Names& names :
       {Names{"a.ply", "b.ply", "c.ply"}, Names{"1.ply", "2.ply", "b9.ply"},  // other words
        Names{"1_1.ply", "2_2.ply", "9_9.ply"},                               // two numbers
        Names{"5.ply", "05.ply", "7.ply"},                                    // the same again
        Names{"3.ply", "2.ply", "9.ply"},                                     // not in order
        Names{"0.ply", "33.ply", "67.ply", "100.ply", "300.ply"},             // times
        Names{"1.ply", "5.ply"}, Names{"1.ply"}, Names{},
        Names{"1.ply", "2.ply", "99999999999999999999.ply"}}) {
    EXPECT_EQ(missing_numbers(names), "");
    EXPECT_THAT(places_by_number(names), IsEmpty());
  }
}

TEST(FileNumbers, many_gaps_are_counted) {
  Names names;
  for (int i = 0; i < 20; ++i)
    for (const int k : {0, 1, 2}) names.push_back(std::to_string(5 * i + k));
  EXPECT_THAT(missing_numbers(names), testing::EndsWith("38 to 39 and 11 more gaps"));
}

}  // namespace
}  // namespace pointreel::file_numbers_test
