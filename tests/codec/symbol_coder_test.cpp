#include "codec/octree/symbol_coder.h"

#include <array>
#include <cmath>
#include <memory>
#include <random>

#include <gtest/gtest.h>

namespace pointreel::symbol_coder_test {
namespace {

/// Learns at random, mostly one symbol for a while and then another.
template <int kSymbols>
Alphabet<kSymbols> random_alphabet(std::mt19937& random) {
  Alphabet<kSymbols> alphabet(1 + static_cast<int>(random() % kSymbols));
  for (auto runs = random() % 8; runs > 0; --runs) {
    const int often = static_cast<int>(random() % kSymbols);
    for (auto times = random() % 200; times > 0; --times) {
      alphabet.update(random() % 4 == 0 ? static_cast<int>(random() % kSymbols) : often);
    }
  }
  return alphabet;
}

template <class T>
class Alphabets : public testing::Test {};

using Sizes = testing::Types<std::integral_constant<int, 8>, std::integral_constant<int, 16>>;
TYPED_TEST_SUITE(Alphabets, Sizes);

TYPED_TEST(Alphabets, give_each_number_to_the_symbol_in_whose_range_it_lies) {
  constexpr int kSymbols = TypeParam::value;
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const auto alphabet = random_alphabet<kSymbols>(random);
    std::uint32_t number = 0;
    for (int symbol = 0; symbol < kSymbols; ++symbol) {
      const SymbolRange range = alphabet.range(symbol);
      ASSERT_EQ(range.begin, number);
      ASSERT_GE(range.size, std::uint32_t{kLeastFrequency});
      for (; number < range.begin + range.size; ++number) {
        SymbolRange found;
        ASSERT_EQ(alphabet.find(number, found), symbol);
        ASSERT_EQ(found.begin, range.begin);
        ASSERT_EQ(found.size, range.size);
      }
    }
    ASSERT_EQ(number, std::uint32_t{kAllFrequencies});
  }
}

TYPED_TEST(Alphabets, learn_as_plain_arithmetic_does) {
  constexpr int kSymbols = TypeParam::value;
  std::mt19937 random(2);
  Alphabet<kSymbols> alphabet;
  std::array<int, kSymbols> sums{};
  for (int i = 0; i < kSymbols; ++i) {
    sums[static_cast<std::size_t>(i)] = 4 * i + i * ((32768 - 4 * kSymbols) / kSymbols);
  }
  for (int n = 0; n < 400; ++n) {
    const int symbol = static_cast<int>(random() % kSymbols * (random() % kSymbols) / kSymbols);
    const int rate = kSymbols == 8 ? n <= 1     ? 1
                                     : n <= 4   ? 2
                                     : n <= 12  ? 3
                                     : n <= 32  ? 4
                                     : n <= 100 ? 5
                                                : 6
                     : n <= 4      ? 3
                     : n <= 10     ? 4
                     : n <= 24     ? 5
                     : n <= 56     ? 6
                     : n <= 120    ? 7
                                   : 8;
    alphabet.update(symbol);
    for (int i = 1; i < kSymbols; ++i) {
      int& sum = sums[static_cast<std::size_t>(i)];
      const int target = i <= symbol ? 4 * i : 32768 - 4 * (kSymbols - i);
      sum += (target - sum) >> rate;
      ASSERT_EQ(alphabet.range(i).begin, static_cast<std::uint32_t>(sum)) << n;
    }
  }
}

TYPED_TEST(Alphabets, begin_with_the_frequencies_that_they_are_given) {
  constexpr int kSymbols = TypeParam::value;
  std::array<std::uint32_t, kSymbols> counts{};
  counts[0] = 3;
  counts[5] = 1;
  const Alphabet<kSymbols> alphabet(counts, 40);
  EXPECT_EQ(alphabet.seen(), 40);
  for (int symbol = 0; symbol < kSymbols; ++symbol) {
    const double share = counts[static_cast<std::size_t>(symbol)] / 4.0;
    EXPECT_NEAR(alphabet.range(symbol).size, share * 32768, 16 * 4) << symbol;
  }
}

TYPED_TEST(Alphabets, estimate_the_bits_that_a_symbol_costs) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const auto alphabet = random_alphabet<TypeParam::value>(random);
    for (int symbol = 0; symbol < TypeParam::value; ++symbol) {
      const double bits = -std::log2(alphabet.range(symbol).size / 32768.0);
      // The table's steps are coarse for rare symbols.
      if (bits < 8.0) {
        EXPECT_NEAR(alphabet.cost(symbol) / 16.0, bits, 0.12);
      }
    }
  }
}

struct Step {
  int state, context, symbol;  ///< of an alphabet of 8 symbols if the context is even
  int bits;
  std::uint32_t value;
};

std::vector<Step> random_steps(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Step> steps;
  for (std::size_t i = 0; i < count; ++i) {
    Step step{static_cast<int>(random() % 2), static_cast<int>(random() % 6), 0,
              random() % 3 == 0 ? static_cast<int>(random() % 33) : 0,
              static_cast<std::uint32_t>(random())};
    step.symbol = static_cast<int>(random() % 8 * (random() % 8) / 8);
    if (step.context % 2 != 0) step.symbol = 2 * step.symbol + static_cast<int>(random() % 2);
    step.value &= static_cast<std::uint32_t>((std::uint64_t{1} << step.bits) - 1);
    steps.push_back(step);
  }
  return steps;
}

/// Codes the steps, and returns those that were coded.
template <class Coder>
std::vector<Step> code(Coder& coder, std::vector<Step> steps) {
  std::array<Alphabet8, 3> small;
  std::array<Alphabet16, 3> large;
  for (Step& step : steps) {
    const auto context = static_cast<std::size_t>(step.context / 2);
    step.symbol = step.context % 2 == 0 ? coder.code(step.state, small[context], step.symbol)
                                        : coder.code(step.state, large[context], step.symbol);
    step.value = coder.bits(step.bits, step.value);
  }
  return steps;
}

Bytes encoded(const std::vector<Step>& steps) {
  Bytes bytes;
  SymbolEncoder encoder;
  code(encoder, steps);
  encoder.finish(bytes);
  return bytes;
}

/// Whether the bytes, in a buffer of exactly their size, decode to these steps. Sets `complete` to
/// what the decoder reports at the end.
bool decodes(const Bytes& bytes, const std::vector<Step>& steps, bool& complete) {
  const auto exact = std::make_unique<std::uint8_t[]>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), exact.get());
  SymbolDecoder decoder({exact.get(), bytes.size()});
  const std::vector<Step> decoded = code(decoder, steps);
  complete = decoder.complete();
  return std::equal(steps.begin(), steps.end(), decoded.begin(), [](const Step& a, const Step& b) {
    return a.symbol == b.symbol && a.value == b.value;
  });
}

TEST(SymbolCoder, restores_every_symbol_and_bit_and_ends_where_the_encoder_ended) {
  for (unsigned seed = 0; seed < 400; ++seed) {
    const auto steps = random_steps(seed, seed);
    const Bytes bytes = encoded(steps);
    bool complete = false;
    ASSERT_TRUE(decodes(bytes, steps, complete)) << seed;
    EXPECT_TRUE(complete) << seed;
  }
}

TEST(SymbolCoder, detects_missing_and_additional_bytes) {
  const auto steps = random_steps(300, 1);
  const Bytes bytes = encoded(steps);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    bool complete = true;
    decodes(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)), steps,
            complete);
    ASSERT_FALSE(complete) << size;
  }
  for (std::size_t at : {std::size_t{0}, std::size_t{14}, bytes.size() / 2, bytes.size()}) {
    for (std::size_t more = 1; more < 12; ++more) {
      Bytes longer = bytes;
      longer.insert(longer.begin() + static_cast<std::ptrdiff_t>(at), more, 0);
      bool complete = true;
      decodes(longer, steps, complete);
      ASSERT_FALSE(complete) << at << " " << more;
    }
  }
}

TEST(SymbolCoder, decodes_arbitrary_bytes_to_some_symbols) {
  std::mt19937 random(4);
  const auto steps = random_steps(500, 2);
  for (int trial = 0; trial < 300; ++trial) {
    Bytes bytes(random() % 200);
    const unsigned most = trial % 2 == 0 ? 255 : 1;
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random() % (most + 1));
    bool complete = true;
    EXPECT_FALSE(decodes(bytes, steps, complete));
    EXPECT_FALSE(complete);
  }
}

TEST(SymbolCoder, needs_as_many_bits_as_the_frequencies_imply) {
  std::mt19937 random(5);
  SymbolEncoder encoder;
  Alphabet8 alphabet;
  double bits = 0.0;
  for (int i = 0; i < 100'000; ++i) {
    const int symbol = std::countr_zero(static_cast<std::uint32_t>(random()) | 128u);
    bits -= std::log2(alphabet.range(symbol).size / 32768.0);
    encoder.code(i % 2, alphabet, symbol);
    encoder.bits(1, static_cast<std::uint32_t>(i & 1));
    bits += 1.0;
  }
  Bytes bytes;
  encoder.finish(bytes);
  EXPECT_NEAR(static_cast<double>(bytes.size()) * 8, bits, 5e-4 * bits);
  EXPECT_LT(bits, 3.05 * 100'000);
}

}  // namespace
}  // namespace pointreel::symbol_coder_test
