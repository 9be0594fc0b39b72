#include "common/base/natural_order.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pointreel::natural_order_test {
namespace {

TEST(NaturalOrder, puts_frame2_before_frame10) {
  EXPECT_TRUE(natural_less("frame2.ply", "frame10.ply"));
  EXPECT_FALSE(natural_less("frame10.ply", "frame2.ply"));
  EXPECT_TRUE(natural_less("take2/frame10", "take10/frame2"));
}

TEST(NaturalOrder, compares_numbers_too_long_for_any_integer_type) {
  const std::string zeros(1000, '0');
  EXPECT_TRUE(natural_less("a" + std::string(500, '8'), "a1" + zeros));
  EXPECT_TRUE(natural_less("a1" + zeros + "1", "a1" + zeros + "2"));
  EXPECT_TRUE(natural_less("a" + zeros + "2", "a10"));
}

TEST(NaturalOrder, breaks_ties_of_equal_numbers_byte_by_byte) {
  EXPECT_TRUE(natural_less("frame01", "frame1"));
  EXPECT_FALSE(natural_less("frame1", "frame01"));
  EXPECT_TRUE(natural_less("frame1a", "frame01b"));  // the following characters decide first
}

TEST(NaturalOrder, does_not_regard_the_case_of_letters_unless_all_else_is_equal) {
  EXPECT_TRUE(natural_less("frame_000.ply", "Frame_001.PLY"));
  EXPECT_TRUE(natural_less("Frame_001.PLY", "frame_002.ply"));
  EXPECT_TRUE(natural_less("A1", "a1"));
  EXPECT_FALSE(natural_less("a1", "A1"));
}

TEST(NaturalOrder, treats_bytes_above_127_as_larger_than_ascii) {
  EXPECT_TRUE(natural_less("z", "\xc3\xa9"));
  EXPECT_FALSE(natural_less("\xc3\xa9", "z"));
}

TEST(NaturalOrder, is_a_strict_total_order) {
  // All strings of up to four characters from an alphabet around the digits.
  std::vector<std::string> names{""};
  for (std::size_t begin = 0, length = 1; length <= 4; ++length) {
    const std::size_t end = names.size();
    for (; begin < end; ++begin) {
      for (const char c : {'/', '0', '1', 'A', 'a'}) names.push_back(names[begin] + c);
    }
  }
  std::sort(names.begin(), names.end(), natural_less);
  // Sorting is only defined for a strict weak order, so check every pair against the result.
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (std::size_t k = 0; k < names.size(); ++k) {
      ASSERT_EQ(natural_less(names[i], names[k]), i < k) << names[i] << " and " << names[k];
    }
  }
}

}  // namespace
}  // namespace pointreel::natural_order_test
