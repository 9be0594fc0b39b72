#include "codec/core/morton.h"

#include <random>

#include <gtest/gtest.h>

#include "pointreel/octree.h"

namespace pointreel::morton_test {
namespace {

std::uint64_t encode_bit_by_bit(const glm::uvec3& cell) {
  std::uint64_t key = 0;
  for (int bit = 0; bit < kMaxDepth; ++bit) {
    for (int axis = 0; axis < 3; ++axis) {
      key |= std::uint64_t{cell[axis] >> bit & 1u} << (3 * bit + axis);
    }
  }
  return key;
}

TEST(Morton, interleaves_like_a_bitwise_loop_and_decodes_back) {
  std::mt19937 random(7);
  for (int i = 0; i < 10000; ++i) {
    const glm::uvec3 cell(random() >> 11, random() >> 11, random() >> 11);
    ASSERT_EQ(morton_encode(cell), encode_bit_by_bit(cell));
    ASSERT_EQ(morton_decode(morton_encode(cell)), cell);
  }
}

TEST(Morton, holds_the_last_cell_of_level_21_in_63_bits) {
  const glm::uvec3 last((1u << kMaxDepth) - 1);
  EXPECT_EQ(morton_encode(last), (std::uint64_t{1} << 63) - 1);
  EXPECT_EQ(morton_decode(morton_encode(last)), last);
}

}  // namespace
}  // namespace pointreel::morton_test
