#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#include "pointreel/bytes.h"

/// A binary range coder (Martin, "Range encoding", 1979): 64 bits of range, 16 bits of probability,
/// four bytes at a time. FORMAT.md, "Range coder".
///
/// Trust: the decoder takes hostile bytes. It never reads past their end but continues with zeros;
/// `complete` tells whether the bytes were those of the decoded decisions.
namespace pointreel {

namespace range_coder {

inline constexpr int kProbabilityBits = 16;
/// The range never falls below this, because four bytes are shifted out first.
inline constexpr std::uint64_t kLeastRange = std::uint64_t{1} << 32;

/// The width of the lower part of the range, which stands for a one.
inline std::uint64_t width_of_one(std::uint64_t range, std::uint64_t probability) {
  return (range >> kProbabilityBits) * probability;
}

}  // namespace range_coder

class RangeEncoder {
 public:
  /// Appends to `out`, which must not be used otherwise until `finish`.
  explicit RangeEncoder(Bytes& out) : out_(&out), begin_(out.size()), end_(out.size()) {}

  /// Codes a bit that is one with probability / 65536, where probability is 1 to 65535. Does not
  /// branch on the bit, since the processor would often mispredict it.
  void encode(unsigned bit, std::uint32_t probability) {
    using namespace range_coder;
    const std::uint64_t zero = std::uint64_t{bit} - 1;  // all ones if the bit is zero
    const std::uint64_t one = width_of_one(range_, probability);
    range_ = __builtin_expect_with_probability(bit != 0, 1, 0.5) ? one : range_ - one;
    carry_ += __builtin_add_overflow(low_, one & zero, &low_) ? 1u : 0u;
    if (__builtin_expect(range_ < kLeastRange, 0)) {
      append_word(static_cast<std::uint32_t>(low_ >> 32));
      low_ <<= 32;
      range_ <<= 32;
    }
  }

  /// Appends the last four bytes.
  void finish();

 private:
  /// Adds the carry to the bytes written so far and appends four bytes, highest first.
  void append_word(std::uint32_t word) {
    if (__builtin_expect(carry_ != 0, 0)) add_carry(*out_, begin_, end_);
    carry_ = 0;
    if (__builtin_expect(out_->size() - end_ < 4, 0)) grow(*out_);
    word = __builtin_bswap32(word);
    std::memcpy(out_->data() + end_, &word, 4);
    end_ += 4;
  }

  // Static, so that an encoder can be kept in registers.
  static void add_carry(Bytes& out, std::size_t begin, std::size_t end);
  static void grow(Bytes& out);

  Bytes* out_;
  std::size_t begin_, end_;  ///< of the bytes written; `out` may be longer until `finish`
  std::uint64_t low_ = 0;
  std::uint64_t range_ = ~std::uint64_t{0};
  unsigned carry_ = 0;  ///< 1 if the bytes written so far must be increased by one
};

class RangeDecoder {
 public:
  explicit RangeDecoder(ByteView bytes) : bytes_(bytes.data()), size_(bytes.size()) {
    value_ = std::uint64_t{next_word()} << 32;
    value_ |= next_word();
  }

  unsigned decode(std::uint32_t probability) {
    using namespace range_coder;
    const std::uint64_t one = width_of_one(range_, probability);
    const bool bit = value_ < one;
    value_ -= bit ? 0 : one;
    range_ = bit ? one : range_ - one;
    if (__builtin_expect(range_ < kLeastRange, 0)) {
      value_ = value_ << 32 | next_word();
      range_ <<= 32;
    }
    return bit;
  }

  /// The same for bits that are nearly random: without a branch, which would be mispredicted.
  unsigned decode_without_branch(std::uint32_t probability) {
    using namespace range_coder;
    const std::uint64_t one = width_of_one(range_, probability);
    const std::uint64_t zero = std::uint64_t{value_ < one} - 1;  // all ones if the bit is zero
    value_ -= one & zero;
    range_ = one + ((range_ - 2 * one) & zero);
    if (__builtin_expect(range_ < kLeastRange, 0)) {
      value_ = value_ << 32 | next_word();
      range_ <<= 32;
    }
    return static_cast<unsigned>(zero + 1);
  }

  /// True if the bytes are exactly those that an encoder makes for the decisions so far, apart from
  /// zeros at the end.
  bool complete() const;

 private:
  static constexpr std::size_t kAhead = 4;  ///< bytes by which the decoder is ahead of the encoder

  std::uint32_t next_word() {
    const std::size_t at = next_;
    next_ += 4;
    if (__builtin_expect(next_ > size_, 0)) return word_at_end(bytes_, size_, at);
    std::uint32_t word;
    std::memcpy(&word, bytes_ + at, 4);
    return __builtin_bswap32(word);
  }

  static std::uint32_t word_at_end(const std::uint8_t* bytes, std::size_t size, std::size_t at);

  const std::uint8_t* bytes_;
  std::size_t size_;
  std::size_t next_ = 0;  ///< may lie past the end
  std::uint64_t value_ = 0;
  std::uint64_t range_ = ~std::uint64_t{0};
};

}  // namespace pointreel
