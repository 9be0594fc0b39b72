#include "codec/octree/symbol_coder.h"

#include <algorithm>

namespace pointreel {

using namespace symbol_coder;

SymbolDecoder::SymbolDecoder(ByteView bytes)
    : states_{kLeastState, kLeastState},
      begin_(bytes.data()),
      end_(bytes.data() + bytes.size()),
      next_(begin_),
      bits_(end_),
      past_end_(bytes.size() < 2 * kStateBytes) {
  if (past_end_) {
    next_ = end_;
    return;
  }
  for (std::uint64_t& state : states_) {
    state = 0;
    for (std::size_t i = 0; i < kStateBytes; ++i) state |= std::uint64_t{*next_++} << (8 * i);
  }
}

void SymbolDecoder::refill(int count) {
  if (bits_ - begin_ >= 4) {
    std::uint32_t word;
    bits_ -= 4;
    std::memcpy(&word, bits_, 4);
    window_ |= std::uint64_t{__builtin_bswap32(word)} << window_bits_;
    window_bits_ += 32;
    return;
  }
  while (window_bits_ < count) {
    if (bits_ > begin_) {
      window_ |= std::uint64_t{*--bits_} << window_bits_;
    } else {
      past_end_ = true;
    }
    window_bits_ += 8;
  }
}

bool SymbolDecoder::complete_but_for_zeros() const {
  // Whole bytes in the window have not been used.
  const std::uint8_t* const bits = bits_ + window_bits_ / 8;
  return !past_end_ && states_[0] == kLeastState && states_[1] == kLeastState && bits >= next_ &&
         (window_ & ((1u << window_bits_ % 8) - 1)) == 0 &&
         std::all_of(next_, bits, [](std::uint8_t byte) { return byte == 0; });
}

bool SymbolDecoder::complete() const {
  return complete_but_for_zeros() && bits_ + window_bits_ / 8 == next_;
}

void SymbolEncoder::finish(Bytes& out) {
  if (window_bits_ > 0) bits_.push_back(static_cast<std::uint8_t>(window_));
  std::uint64_t states[2] = {kLeastState, kLeastState};
  std::vector<std::uint32_t> words;
  for (std::size_t i = symbols_.size(); i-- > 0;) {
    const Symbol& symbol = symbols_[i];
    std::uint64_t& x = states[symbol.state];
    // The decoder's new state must be at least the least one.
    if (x >= std::uint64_t{symbol.size} << (kStateBits + 32 - kFrequencyBits)) {
      words.push_back(static_cast<std::uint32_t>(x));
      x >>= 32;
    }
    x = (x / symbol.size << kFrequencyBits) + x % symbol.size + symbol.begin;
  }
  out.reserve(out.size() + 2 * kStateBytes + 4 * words.size() + bits_.size());
  const auto put = [&out](std::uint64_t value, std::size_t bytes) {
    for (; bytes > 0; --bytes, value >>= 8) out.push_back(static_cast<std::uint8_t>(value));
  };
  for (const std::uint64_t state : states) put(state, kStateBytes);
  for (std::size_t i = words.size(); i-- > 0;) put(words[i], 4);
  out.insert(out.end(), bits_.rbegin(), bits_.rend());
  *this = {};
}

}  // namespace pointreel
