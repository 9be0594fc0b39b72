#include "codec/octree/range_coder.h"

namespace pointreel {

void range_coder::append_word(Bytes& out, std::size_t begin, std::uint32_t word, bool carry) {
  // A carry never runs past the first byte: the number coded so far is below one.
  for (std::size_t i = out.size(); carry && i > begin; --i) carry = ++out[i - 1] == 0;
  const std::size_t at = out.size();
  out.resize(at + 4);
  word = __builtin_bswap32(word);
  std::memcpy(out.data() + at, &word, 4);
}

void RangeEncoder::finish() {
  // The number in [low, low + range) with the most zeros at its end; at least 32, as the range is
  // at least 2^32.
  std::uint64_t value = low_;
  int zeros = 56;
  for (; zeros >= 32; zeros -= 8) {
    const std::uint64_t below = (std::uint64_t{1} << zeros) - 1;
    value = (low_ + below) & ~below;
    if (value - low_ < range_) break;
  }
  carry_ |= value < low_;
  range_coder::append_word(*out_, begin_, static_cast<std::uint32_t>(value >> 32), carry_);
  out_->resize(out_->size() - static_cast<std::size_t>((zeros - 32) / 8));
}

std::uint32_t RangeDecoder::word_at_end(const std::uint8_t* bytes, std::size_t size,
                                        std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = at; i < at + 4; ++i) word = word << 8 | (i < size ? bytes[i] : 0u);
  return word;
}

bool RangeDecoder::complete() const {
  if (next_ >= size_) return next_ - size_ <= 7;
  for (std::size_t i = next_; i < size_; ++i) {
    if (bytes_[i] != 0) return false;
  }
  return true;
}

}  // namespace pointreel
