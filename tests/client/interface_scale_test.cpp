#include "client/ui/interface_scale.h"

#include <gtest/gtest.h>

namespace pointreel::interface_scale_test {
namespace {

TEST(InterfaceScale, follows_the_display_and_is_larger_on_screens_of_many_pixels) {
  EXPECT_EQ(automatic_interface_scale(1.0f, 0), 1.0f);
  EXPECT_EQ(automatic_interface_scale(1.0f, 768), 1.0f);
  EXPECT_EQ(automatic_interface_scale(1.0f, 1080), 1.0f);
  EXPECT_EQ(automatic_interface_scale(1.0f, 1440), 1.0f);
  EXPECT_EQ(automatic_interface_scale(1.0f, 2160), 1.5f);
  EXPECT_EQ(automatic_interface_scale(1.0f, 2880), 2.0f);
  EXPECT_EQ(automatic_interface_scale(1.25f, 1080), 1.25f);
  EXPECT_EQ(automatic_interface_scale(2.0f, 2160), 2.0f) << "what the display asks counts";
  EXPECT_EQ(automatic_interface_scale(100.0f, 2160), 4.0f);
}

TEST(InterfaceScale, goes_through_all_steps_and_stops_at_the_ends) {
  double scale = 1.1;
  EXPECT_EQ(next_interface_scale(scale, true), 1.25);
  EXPECT_EQ(next_interface_scale(scale, false), 1.0);
  for (int i = 0; i < 20; ++i) {
    const double larger = next_interface_scale(scale, true);
    EXPECT_TRUE(larger > scale || larger == kMostInterfaceScale);
    scale = larger;
  }
  EXPECT_EQ(scale, kMostInterfaceScale);
  for (int i = 0; i < 20; ++i) scale = next_interface_scale(scale, false);
  EXPECT_EQ(scale, kLeastInterfaceScale);
}

}  // namespace
}  // namespace pointreel::interface_scale_test
