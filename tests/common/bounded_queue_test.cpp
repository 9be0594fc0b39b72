#include "common/threads/bounded_queue.h"

#include <atomic>
#include <latch>
#include <memory>
#include <numeric>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace pointreel::bounded_queue_test {
namespace {

TEST(BoundedQueue, returns_values_in_the_order_of_arrival) {
  BoundedQueue<int> queue(3);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(queue.push(i));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(queue.pop(), i);
}

TEST(BoundedQueue, carries_move_only_values) {
  BoundedQueue<std::unique_ptr<int>> queue(1);
  EXPECT_TRUE(queue.push(std::make_unique<int>(7)));
  EXPECT_EQ(**queue.pop(), 7);
}

TEST(BoundedQueue, never_exceeds_its_capacity_and_loses_nothing) {
  constexpr int kValues = 2000;
  BoundedQueue<int> queue(2);
  std::atomic<int> in{0}, out{0};
  std::atomic<long> sum{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 2; ++t)
    threads.emplace_back([&] {
      for (int i; (i = in++) < kValues;) queue.push(i);
    });
  std::vector<std::thread> readers;
  for (int t = 0; t < 2; ++t)
    readers.emplace_back([&] {
      while (auto value = queue.pop()) {
        EXPECT_LE(queue.size(), 2u);
        sum += *value;
        ++out;
      }
    });
  for (std::thread& thread : threads) thread.join();
  queue.close();
  for (std::thread& thread : readers) thread.join();
  EXPECT_EQ(out, kValues);
  EXPECT_EQ(sum, long{kValues} * (kValues - 1) / 2);
}

TEST(BoundedQueue, closing_wakes_a_waiting_reader_and_a_waiting_writer) {
  // There are enough rounds for the queue to be closed before, while and after its thread begins to
  // wait.
  for (int round = 0; round < 200; ++round) {
    BoundedQueue<int> empty(1), full(1);
    full.push(1);
    std::latch here(3);
    std::thread reader([&] {
      here.arrive_and_wait();
      EXPECT_EQ(empty.pop(), std::nullopt);
    });
    std::thread writer([&] {
      here.arrive_and_wait();
      EXPECT_FALSE(full.push(2));
    });
    here.arrive_and_wait();
    for (int i = 0; i < round; ++i) std::this_thread::yield();
    empty.close();
    full.close();
    reader.join();
    writer.join();
    ASSERT_EQ(full.pop(), 1) << "elements queued before closing can still be taken";
    ASSERT_EQ(full.pop(), std::nullopt);
  }
}

}  // namespace
}  // namespace pointreel::bounded_queue_test
