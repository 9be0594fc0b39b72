#include "common/threads/ordered_turns.h"

#include <stdexcept>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pointreel::ordered_turns_test {
namespace {

TEST(OrderedTurns, come_in_the_order_of_their_numbers) {
  OrderedTurns turns;
  std::vector<int> order;
  {
    std::vector<std::jthread> threads;
    for (int lane = 3; lane >= 0; --lane) {
      threads.emplace_back([&, lane] {
        for (int i = lane; i < 100; i += 4) {
          turns.take(static_cast<std::uint64_t>(i), [&] { order.push_back(i); });
        }
      });
    }
  }
  std::vector<int> expected;
  for (int i = 0; i < 100; ++i) expected.push_back(i);
  EXPECT_EQ(order, expected);
}

TEST(OrderedTurns, end_even_if_they_fail) {
  OrderedTurns turns;
  EXPECT_THROW(turns.take(0, [] { throw std::runtime_error("failed"); }), std::runtime_error);
  bool reached = false;
  turns.take(1, [&] { reached = true; });
  EXPECT_TRUE(reached);
}

}  // namespace
}  // namespace pointreel::ordered_turns_test
