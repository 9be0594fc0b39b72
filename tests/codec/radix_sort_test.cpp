#include "codec/core/radix_sort.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "tests/executors.h"

namespace pointreel::radix_sort_test {
namespace {

void expect_sorted_like_the_library(std::vector<KeyIndex> items) {
  std::vector<KeyIndex> expected = items;
  std::stable_sort(expected.begin(), expected.end(),
                   [](const KeyIndex& a, const KeyIndex& b) { return a.key < b.key; });
  radix_sort(items);
  ASSERT_EQ(items.size(), expected.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    ASSERT_EQ(items[i].key, expected[i].key) << i;
    ASSERT_EQ(items[i].index, expected[i].index) << i;
  }
}

std::vector<KeyIndex> random_items(std::size_t n, int bits) {
  std::mt19937_64 random(n);
  std::vector<KeyIndex> items;
  for (std::uint32_t i = 0; i < n; ++i) items.push_back({random() >> (64 - bits), i});
  return items;
}

TEST(RadixSort, agrees_with_a_stable_sort) {
  for (const std::size_t n : {0u, 1u, 2u, 3u, 1000u, 70000u}) {
    for (const int bits : {1, 11, 12, 30, 63})
      expect_sorted_like_the_library(random_items(n, bits));
  }
}

TEST(RadixSort, keeps_the_order_of_equal_keys) {
  std::vector<KeyIndex> items;
  for (std::uint32_t i = 0; i < 5000; ++i) items.push_back({i % 3, i});
  expect_sorted_like_the_library(items);
}

TEST(RadixSort, agrees_with_a_stable_sort_of_packed_items) {
  for (const int bits : {1, 11, 12, 30, 33}) {
    std::vector<KeyIndex> expected = random_items(3000, bits);
    std::vector<std::uint64_t> packed;
    for (const KeyIndex& item : expected)
      packed.push_back(item.key << kPackedIndexBits | item.index);
    std::stable_sort(expected.begin(), expected.end(),
                     [](const KeyIndex& a, const KeyIndex& b) { return a.key < b.key; });
    std::vector<std::uint64_t> spare(packed.size());
    const auto sorted = radix_sort(packed, spare, bits);
    for (std::size_t i = 0; i < packed.size(); ++i) {
      ASSERT_EQ(sorted[i], expected[i].key << kPackedIndexBits | expected[i].index) << i;
    }
  }
}

TEST(RadixSort, sorts_input_that_is_sorted_or_nearly_sorted) {
  std::vector<KeyIndex> items;
  for (std::uint32_t i = 0; i < 5000; ++i) items.push_back({i / 2, i});
  expect_sorted_like_the_library(items);
  items.push_back({7, 5000});
  expect_sorted_like_the_library(items);
}

TEST(RadixSort, is_the_same_for_any_number_of_threads) {
  // From less than one block to several, with few and many items of the same key.
  for (const std::size_t n : {1000u, 65535u, 65536u, 98304u, 200001u}) {
    for (const int bits : {1, 7, 33, 63}) {
      const std::vector<KeyIndex> items = random_items(n, bits);
      std::vector<KeyIndex> expected = items;
      radix_sort(expected);
      for (const Executor& executor : some_executors()) {
        std::vector<KeyIndex> sorted = items;
        radix_sort(sorted, 63, executor);
        ASSERT_TRUE(std::ranges::equal(sorted, expected,
                                       [](const KeyIndex& a, const KeyIndex& b) {
                                         return a.key == b.key && a.index == b.index;
                                       }))
            << n << " items, " << bits << " bits";
      }
    }
  }
}

TEST(RadixSort, sees_a_single_item_that_is_out_of_order_anywhere) {
  std::vector<KeyIndex> sorted;
  for (std::uint32_t i = 0; i < 131072; ++i) sorted.push_back({i, i});
  const Executor two = threads_executor(2);
  for (const std::size_t at : {0u, 32767u, 32768u, 65535u, 65536u, 98303u, 131070u}) {
    std::vector<KeyIndex> items = sorted;
    std::swap(items[at], items[at + 1]);
    radix_sort(items, 63, two);
    for (std::size_t i = 0; i < items.size(); ++i) ASSERT_EQ(items[i].index, i) << at;
  }
}

}  // namespace
}  // namespace pointreel::radix_sort_test
