#include "common/base/enum_names.h"

#include <gtest/gtest.h>

namespace pointreel {
namespace enum_names_test {

enum class Shape { disc = 1, cube = 4 };

}  // namespace enum_names_test

template <>
inline constexpr auto kEnumNames<enum_names_test::Shape> =
    std::to_array<EnumName<enum_names_test::Shape>>(
        {{enum_names_test::Shape::disc, "disc"}, {enum_names_test::Shape::cube, "cube"}});

namespace enum_names_test {
namespace {

TEST(EnumNames, every_value_has_a_name_and_every_name_a_value) {
  EXPECT_STREQ(name(Shape::disc), "disc");
  EXPECT_STREQ(name(Shape::cube), "cube");
  EXPECT_EQ(parse_enum<Shape>("disc"), Shape::disc);
  EXPECT_EQ(parse_enum<Shape>("cube"), Shape::cube);
  EXPECT_EQ(list_names<Shape>(), "disc, cube");
}

TEST(EnumNames, other_numbers_have_no_name_and_other_names_no_value) {
  EXPECT_STREQ(name(static_cast<Shape>(2)), "");
  EXPECT_EQ(parse_enum<Shape>(""), std::nullopt);
  EXPECT_EQ(parse_enum<Shape>("dis"), std::nullopt);
  EXPECT_EQ(parse_enum<Shape>("Disc"), std::nullopt);
}

TEST(EnumNames, the_first_value_follows_the_last) {
  EXPECT_EQ(next(Shape::disc), Shape::cube);
  EXPECT_EQ(next(Shape::cube), Shape::disc);
}

}  // namespace
}  // namespace enum_names_test
}  // namespace pointreel
