#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "codec/octree/alphabet.h"
#include "pointreel/bytes.h"

/// Codes symbols of adaptive alphabets by asymmetric numeral systems (J. Duda, "Asymmetric numeral
/// systems: entropy coding combining speed of Huffman coding with compression rate of arithmetic
/// coding", 2013), with two states, so that a processor decodes two symbols at once (F. Giesen,
/// "Interleaved entropy coders", 2014). FORMAT.md, "Symbol coder".
///
/// A stream begins with both states. Words of 32 bits follow, which the states share. Bits that are
/// not worth modelling are kept as they are, from the stream's end on backwards.
///
/// Coding is written once for both directions: `code` returns the symbol, which the encoder is
/// given, and `bits` the bits.
namespace pointreel {

namespace symbol_coder {

/// A state is at least 2^kStateBits and less than 2^(kStateBits + 32), between symbols.
inline constexpr int kStateBits = 24;
inline constexpr std::uint64_t kLeastState = std::uint64_t{1} << kStateBits;
inline constexpr std::size_t kStateBytes = (kStateBits + 32) / 8;

}  // namespace symbol_coder

/// The most bits that are coded at once.
inline constexpr int kMostBits = 32;

/// Trust: takes hostile bytes. It never reads past their end but continues with zeros; `complete`
/// tells whether the bytes were exactly those of what was decoded.
class SymbolDecoder {
 public:
  static constexpr bool kEncodes = false;

  /// The bytes must outlive the decoder. Copies continue where the original is.
  explicit SymbolDecoder(ByteView bytes);

  /// Decodes a symbol with state 0 or 1.
  template <int kSymbols>
  [[gnu::always_inline]] int code(int state, Alphabet<kSymbols>& alphabet, int = 0) {
    std::uint64_t& x = states_[state];
    const std::uint32_t number = static_cast<std::uint32_t>(x) & (kAllFrequencies - 1);
    SymbolRange range;
    const int symbol = alphabet.find(number, range);
    x = range.size * (x >> kFrequencyBits) + number - range.begin;
    if (__builtin_expect(x < symbol_coder::kLeastState, 0)) x = x << 32 | next_word();
    alphabet.update(symbol);
    return symbol;
  }

  /// Reads bits, the lowest first. `count`: 0 to kMostBits.
  [[gnu::always_inline]] std::uint32_t bits(int count, std::uint32_t = 0) {
    if (__builtin_expect(window_bits_ < count, 0)) refill(count);
    const auto value = static_cast<std::uint32_t>(window_ & ((std::uint64_t{1} << count) - 1));
    window_ >>= count;
    window_bits_ -= count;
    return value;
  }

  bool complete() const;
  /// The same, but there may be zeros between the words and the bits.
  bool complete_but_for_zeros() const;

 private:
  std::uint32_t next_word() {
    if (__builtin_expect(end_ - next_ < 4, 0)) {
      past_end_ = true;
      return 0;
    }
    std::uint32_t word;
    std::memcpy(&word, next_, 4);
    next_ += 4;
    return word;
  }

  [[gnu::noinline]] void refill(int count);

  std::uint64_t states_[2];
  const std::uint8_t *begin_, *end_;
  const std::uint8_t* next_;  ///< the next word
  const std::uint8_t* bits_;  ///< the end of the bits that are still to be read
  std::uint64_t window_ = 0;  ///< bits that have been read
  int window_bits_ = 0;
  bool past_end_ = false;
};

/// Collects symbols and bits. The symbols are coded in reverse order, so all of them are kept until
/// the end: 6 bytes each.
class SymbolEncoder {
 public:
  static constexpr bool kEncodes = true;

  template <int kSymbols>
  int code(int state, Alphabet<kSymbols>& alphabet, int symbol) {
    const SymbolRange range = alphabet.range(symbol);
    symbols_.push_back({static_cast<std::uint16_t>(range.begin),
                        static_cast<std::uint16_t>(range.size), static_cast<std::uint16_t>(state)});
    alphabet.update(symbol);
    return symbol;
  }

  std::uint32_t bits(int count, std::uint32_t value) {
    window_ |= std::uint64_t{value} << window_bits_;
    for (window_bits_ += count; window_bits_ >= 8; window_bits_ -= 8) {
      bits_.push_back(static_cast<std::uint8_t>(window_));
      window_ >>= 8;
    }
    return value;
  }

  /// Appends the stream to `out`. The encoder is then as good as new.
  void finish(Bytes& out);

 private:
  struct Symbol {
    std::uint16_t begin, size, state;
  };

  std::vector<Symbol> symbols_;
  Bytes bits_;
  std::uint64_t window_ = 0;
  int window_bits_ = 0;
};

}  // namespace pointreel
