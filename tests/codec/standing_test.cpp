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

/// Boxes of things that stand with y up: people, in captures that are made in different ways and
/// synthetic ones, and a statue.
const std::vector<Box> kStanding = {
    kPerson,
    {{-0.263, -0.001, -0.586}, {0.323, 1.769, -0.048}},  // beside the origin
    {{-0.451, -0.018, -0.195}, {0.462, 1.520, 0.341}},
    {{-0.511, 0.002, -0.370}, {0.475, 1.293, 0.454}},
    {{-0.291, 0.006, -0.500}, {0.749, 1.763, 0.601}},
    {{2.0, 0.0, 3.0}, {2.8, 1.8, 3.6}},
};

/// Turned, so that another axis points up.
Box turned(const Box& box, Up up) {
  const auto place = [&](const glm::dvec3& p) {
    glm::dvec3 to;
    const int axis = up.axis();
    to[axis] = up.reversed() ? -p.y : p.y;
    to[(axis + 1) % 3] = p.z;
    to[(axis + 2) % 3] = p.x;
    return to;
  };
  Box out;
  out.grow(place(box.min));
  out.grow(place(box.max));
  return out;
}

TEST(Standing, nothing_is_said_of_what_stands_and_something_of_all_on_their_heads) {
  for (const Box& box : kStanding) {
    for (const char axis : {'x', 'y', 'z'}) {
      for (const bool down : {false, true}) {
        const Up up{axis, down};
        SCOPED_TRACE(testing::Message() << box.min.x << " up " << up.text());
        EXPECT_EQ(standing_warning(turned(box, up), up), std::nullopt);
        EXPECT_THAT(standing_warning(turned(box, up), up.opposite()),
                    Optional(HasSubstr("on its head; --up " + std::string(up.text()))));
      }
    }
  }
}

TEST(Standing, nothing_is_said_without_a_floor_or_a_longest_axis) {
  EXPECT_EQ(standing_warning({{-0.4, -0.9, -0.3}, {0.4, 0.9, 0.3}}, 'y'), std::nullopt);
  EXPECT_EQ(standing_warning({{-2.0, -1.8, -0.3}, {2.0, 0.0, 0.3}}, 'y'), std::nullopt);
  EXPECT_EQ(standing_warning({{0.0, -1.0, 5.0}, {30.0, 1.0, 9.0}}, 'y'), std::nullopt);
  EXPECT_EQ(standing_warning({}, 'y'), std::nullopt);
}

}  // namespace
}  // namespace pointreel::standing_test
