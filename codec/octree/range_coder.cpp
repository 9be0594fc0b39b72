#include "codec/octree/range_coder.h"

#include <algorithm>

namespace pointreel {

void RangeEncoder::add_carry(Bytes& out, std::size_t begin, std::size_t end) {
  // This never runs past the first byte, because the number coded so far is below one.
  while (end > begin && ++out[--end] == 0) {
  }
}

void RangeEncoder::grow(Bytes& out) { out.resize(2 * out.size() + 4096); }

void RangeEncoder::finish() {
  // The range is at least 2^32, so it contains a number whose low half is zero.
  const std::uint64_t value = low_ + (range_coder::kLeastRange - 1);
  carry_ += value < low_ ? 1u : 0u;
  append_word(static_cast<std::uint32_t>(value >> 32));
  out_->resize(end_);
}

std::uint32_t RangeDecoder::word_at_end(const std::uint8_t* bytes, std::size_t size,
                                        std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = at; i < at + 4; ++i) word = word << 8 | (i < size ? bytes[i] : 0u);
  return word;
}

bool RangeDecoder::complete() const {
  const std::size_t end = next_ - kAhead;
  return end <= size_ && std::all_of(bytes_ + end, bytes_ + size_, [](auto b) { return b == 0; });
}

}  // namespace pointreel
