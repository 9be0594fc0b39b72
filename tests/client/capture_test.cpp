#include <gtest/gtest.h>

#include "client/record/numbered_path.h"

namespace pointreel::capture_test {
namespace {

TEST(NumberedPath, inserts_the_number_into_the_pattern) {
  EXPECT_EQ(NumberedPath::parse("out-%04d.png")->at(7), "out-0007.png");
  EXPECT_EQ(NumberedPath::parse("%d")->at(123), "123");
  EXPECT_EQ(NumberedPath::parse("a%3d.png")->at(5), "a  5.png");
  EXPECT_EQ(NumberedPath::parse("%02d.png")->at(12345), "12345.png");
  EXPECT_EQ(NumberedPath::parse("100%%-%03d%%")->at(1), "100%-001%");
}

TEST(NumberedPath, refuses_every_other_pattern) {
  for (const char* pattern : {"", "out.png", "%", "out-%", "%s", "%n", "%d%d", "%x.png", "%04",
                              "%-4d", "%ld", "%99999999999999999999d", "%*d", "%1$d", "100%%"})
    EXPECT_FALSE(NumberedPath::parse(pattern)) << pattern;
}

}  // namespace
}  // namespace pointreel::capture_test
