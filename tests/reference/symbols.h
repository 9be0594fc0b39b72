#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pointreel/bytes.h"

/// Alphabets and the symbol coder as codec/FORMAT.md describes them, in the simplest way.
namespace pointreel::reference {

struct Symbols {
  std::vector<int> c;  ///< cumulative frequencies, one more than there are symbols
  int n = 0;

  /// `frequencies`: f[0] to f[K - 1].
  Symbols(const std::vector<long long>& frequencies, int seen) : n(seen) {
    const int k = static_cast<int>(frequencies.size());
    long long all = 0, before = 0;
    for (const long long f : frequencies) all += f;
    for (int i = 0; i <= k; ++i) {
      c.push_back(static_cast<int>(4 * i + before * (32768 - 4 * k) / all));
      if (i < k) before += frequencies[static_cast<std::size_t>(i)];
    }
  }

  void learn(int s) {
    const int k = static_cast<int>(c.size()) - 1;
    int r;
    if (k == 8) {
      r = n <= 1 ? 1 : n <= 4 ? 2 : n <= 12 ? 3 : n <= 32 ? 4 : n <= 100 ? 5 : 6;
    } else {
      r = n <= 10 ? 4 : n <= 30 ? 5 : n <= 90 ? 6 : 7;
    }
    for (int i = 1; i < k; ++i) {
      const int t = i <= s ? 4 * i : 32768 - 4 * (k - i);
      c[static_cast<std::size_t>(i)] += (t - c[static_cast<std::size_t>(i)]) >> r;
    }
    n = std::min(n + 1, 127);
  }
};

class MaskSymbols {
 public:
  explicit MaskSymbols(ByteView bytes) : bytes_(bytes) {
    for (std::uint64_t& x : x_) x = number(7);
  }

  int symbol(int state, Symbols& alphabet) {
    std::uint64_t& x = x_[state];
    const auto slot = static_cast<int>(x & 32767);
    int s = 0;
    while (alphabet.c[static_cast<std::size_t>(s) + 1] <= slot) ++s;
    const int first = alphabet.c[static_cast<std::size_t>(s)],
              end = alphabet.c[static_cast<std::size_t>(s) + 1];
    x = static_cast<std::uint64_t>(end - first) * (x >> 15) + static_cast<unsigned>(slot - first);
    if (x < 1u << 24) x = (x << 32) | number(4);
    alphabet.learn(s);
    return s;
  }

  /// True if the stream ends here, apart from zeros.
  bool complete() const {
    if (x_[0] != 1u << 24 || x_[1] != 1u << 24 || at_ > bytes_.size()) return false;
    for (std::size_t i = at_; i < bytes_.size(); ++i) {
      if (bytes_[i] != 0) return false;
    }
    return true;
  }

 private:
  std::uint64_t number(int size) {
    std::uint64_t value = 0;
    for (int i = 0; i < size; ++i, ++at_) {
      if (at_ < bytes_.size()) value |= std::uint64_t{bytes_[at_]} << (8 * i);
    }
    return value;
  }

  ByteView bytes_;
  std::size_t at_ = 0;
  std::uint64_t x_[2];
};

}  // namespace pointreel::reference
