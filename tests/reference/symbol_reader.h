#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pointreel/bytes.h"

namespace pointreel::reference {

/// An alphabet as FORMAT.md describes it ("Alphabets").
class Alphabet {
 public:
  /// The first `used` of `symbols` symbols are used.
  Alphabet(int symbols, int used);
  /// Begins with these counts.
  explicit Alphabet(const std::vector<std::int64_t>& counts);

  /// The symbol for which a number stands.
  int symbol(std::int64_t number) const;
  /// The cumulative frequencies, one more than there are symbols.
  const std::vector<std::int64_t>& frequencies() const { return c_; }
  void learn(int symbol);
  /// Says how many symbols have been seen.
  void set_seen(int n) { n_ = n; }

 private:
  std::vector<std::int64_t> c_;
  int n_ = 0;
};

/// Reads a stream as FORMAT.md describes it ("Symbol coder").
class SymbolReader {
 public:
  explicit SymbolReader(ByteView bytes);

  int symbol(int state, Alphabet& alphabet);
  std::int64_t bits(int count);
  /// True if the stream ends here.
  bool complete() const;
  /// The same, but there may be zeros behind the words of a stream without bits.
  bool complete_but_for_zeros() const;

 private:
  std::uint64_t take(int bytes);

  ByteView bytes_;
  std::array<std::uint64_t, 2> states_{};
  std::size_t next_ = 0;       ///< the number of bytes read at the front
  std::size_t bits_read_ = 0;  ///< from the end
};

}  // namespace pointreel::reference
