#include "codec/octree/range_coder.h"

#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "codec/octree/bit_extract.h"
#include "pointreel/cpu.h"

namespace pointreel {
namespace {

struct Decision {
  unsigned bit;
  std::uint32_t probability;
};

std::vector<Decision> random_decisions(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Decision> decisions;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t extreme[3] = {1, 65535, 1 + static_cast<std::uint32_t>(random() % 65535)};
    const std::uint32_t probability = extreme[random() % 3];
    // Mostly the probable decision, now and then the other.
    const unsigned bit = random() % 65536 < probability ? 1 : 0;
    decisions.push_back({random() % 50 == 0 ? 1 - bit : bit, probability});
  }
  return decisions;
}

Bytes coded(const std::vector<Decision>& decisions) {
  Bytes bytes;
  RangeEncoder encoder(bytes);
  for (const Decision& d : decisions) encoder.encode(d.bit, d.probability);
  encoder.finish();
  return bytes;
}

/// Whether the bytes, in a buffer of exactly their size, decode to these decisions. Sets `complete`
/// to what the decoder reports at the end.
bool decodes(const Bytes& bytes, const std::vector<Decision>& decisions, bool& complete) {
  const auto exact = std::make_unique<std::uint8_t[]>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), exact.get());
  RangeDecoder decoder({exact.get(), bytes.size()});
  bool equal = true, without_branch = false;
  for (const Decision& d : decisions) {
    // Alternates between the two ways of decoding, which must give the same result.
    without_branch = !without_branch;
    equal &= (without_branch ? decoder.decode_without_branch(d.probability)
                             : decoder.decode(d.probability)) == d.bit;
  }
  complete = decoder.complete();
  return equal;
}

TEST(RangeCoder, restores_every_decision_and_ends_where_the_encoder_ended) {
  for (unsigned seed = 0; seed < 400; ++seed) {
    const auto decisions = random_decisions(seed, seed);
    const Bytes bytes = coded(decisions);
    bool complete = false;
    ASSERT_TRUE(decodes(bytes, decisions, complete)) << seed;
    EXPECT_TRUE(complete) << seed;
    Bytes longer = bytes;
    longer.resize(bytes.size() + 20);
    EXPECT_TRUE(decodes(longer, decisions, complete));
    EXPECT_TRUE(complete) << "trailing zeros may follow";
    longer.back() = 1;
    EXPECT_TRUE(decodes(longer, decisions, complete));
    EXPECT_FALSE(complete);
  }
}

TEST(RangeCoder, propagates_carries_through_bytes_of_all_ones) {
  // Zeros where a one has a tiny probability push `low` to just below a power of two, and the
  // decisions after them carry. Every such sequence must decode correctly.
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    std::vector<Decision> decisions;
    for (int i = 0; i < 300; ++i) {
      decisions.push_back({random() % 8 == 0 ? 1u : 0u, random() % 4 == 0 ? 65535u : 1u});
    }
    bool complete = false;
    ASSERT_TRUE(decodes(coded(decisions), decisions, complete)) << seed;
    EXPECT_TRUE(complete);
  }
}

TEST(RangeCoder, needs_as_many_bits_as_the_probabilities_imply) {
  std::mt19937 random(3);
  std::vector<Decision> decisions;
  for (int i = 0; i < 100'000; ++i) decisions.push_back({random() % 16 == 0 ? 1u : 0u, 4096});
  // The entropy of a bit with probability one in sixteen is 0.3373 bits.
  EXPECT_NEAR(static_cast<double>(coded(decisions).size()) * 8 / 100'000, 0.337, 0.01);
}

TEST(RangeCoder, detects_missing_bytes) {
  const auto decisions = random_decisions(2000, 1);
  const Bytes bytes = coded(decisions);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    bool complete = true;
    const Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    decodes(cut, decisions, complete);
    ASSERT_FALSE(complete) << size;
  }
}

#if defined(__x86_64__)
TEST(BitExtract, is_the_same_in_hardware_and_without) {
  if ((cpu_features() & kCpuBmi2) == 0) GTEST_SKIP() << "this processor has no BMI2";
  std::mt19937_64 random(1);
  for (int i = 0; i < 20'000; ++i) {
    std::uint64_t mask = random();
    for (std::uint64_t thin = random() % 5; thin > 0; --thin) mask &= random();
    const std::uint64_t word = random();
    ASSERT_EQ(HardwareExtract::extract(word, mask), PortableExtract::extract(word, mask));
  }
}
#endif

}  // namespace
}  // namespace pointreel
