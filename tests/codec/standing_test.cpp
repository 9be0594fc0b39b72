// Which captures seem to stand on their heads.

#include "codec/package/standing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pointreel::standing_test {
namespace {

using testing::HasSubstr;
using testing::Optional;

const Box kPerson = {{-0.4, 0.0, -0.3}, {0.4, 1.8, 0.3}};
const Box kHanging = {{-0.4, -1.8, -0.3}, {0.4, 0.01, 0.3}};
const Box kLying = {{-0.4, -0.3, -0.02}, {0.4, 0.3, 1.8}};

TEST(Standing, a_capture_below_its_floor_stands_on_its_head) {
  EXPECT_EQ(standing_warning(kPerson, 'y'), std::nullopt);
  EXPECT_THAT(standing_warning(kHanging, 'y'), Optional(HasSubstr("on its head; --up -y ")));
  EXPECT_EQ(standing_warning(kHanging, {'y', true}), std::nullopt);
  EXPECT_THAT(standing_warning(kPerson, {'y', true}), Optional(HasSubstr("on its head; --up y ")));
}

TEST(Standing, a_capture_whose_floor_is_at_another_axis_lies_on_its_side) {
  EXPECT_THAT(standing_warning(kLying, 'y'), Optional(HasSubstr("on its side; --up z ")));
  EXPECT_EQ(standing_warning(kLying, 'z'), std::nullopt);
}

TEST(Standing, nothing_is_said_without_a_floor_or_a_longest_axis) {
  EXPECT_EQ(standing_warning({{-0.4, -0.9, -0.3}, {0.4, 0.9, 0.3}}, 'y'), std::nullopt);
  EXPECT_EQ(standing_warning({{-2.0, -1.8, -0.3}, {2.0, 0.0, 0.3}}, 'y'), std::nullopt);
  EXPECT_EQ(standing_warning({{0.0, -1.0, 5.0}, {30.0, 1.0, 9.0}}, 'y'), std::nullopt);
  EXPECT_EQ(standing_warning({}, 'y'), std::nullopt);
}

}  // namespace
}  // namespace pointreel::standing_test
