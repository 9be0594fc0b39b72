#include "common/base/pace.h"

#include <gtest/gtest.h>

#include "common/http/http_transfer.h"

namespace pointreel::pace_test {
namespace {

using namespace std::chrono_literals;

constexpr Pace::Clock::time_point kTime(1h);

TEST(Pace, lets_the_slowest_honest_link_pass_and_no_drip) {
  Pace modem(HttpTransfer::kLeastRate), drip(HttpTransfer::kLeastRate);
  // An eighth of 56 kbit/s, for ten minutes; and four bytes a second.
  auto now = kTime;
  for (int i = 0; i < 6000; ++i, now += 100ms) {
    modem.came(87, now);
    ASSERT_LT(now + 5s, modem.due());
  }
  drip.came(1, kTime);
  for (now = kTime; now < drip.due(); now += 250ms) drip.came(1, now);
  EXPECT_LT(now, kTime + 6s);
}

}  // namespace
}  // namespace pointreel::pace_test
