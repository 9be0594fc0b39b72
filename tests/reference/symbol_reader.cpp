#include "tests/reference/symbol_reader.h"

#include <algorithm>

namespace pointreel::reference {

Alphabet::Alphabet(int symbols, int used) {
  for (int i = 0; i <= symbols; ++i) {
    c_.push_back(4 * i + std::min(i, used) * (32768 - 4 * symbols) / used);
  }
}

Alphabet::Alphabet(const std::vector<std::int64_t>& counts) {
  const auto symbols = static_cast<std::int64_t>(counts.size());
  std::int64_t all = 0, before = 0;
  for (const std::int64_t count : counts) all += count;
  for (std::int64_t i = 0; i <= symbols; ++i) {
    c_.push_back(4 * i + before * (32768 - 4 * symbols) / all);
    if (i < symbols) before += counts[static_cast<std::size_t>(i)];
  }
}

int Alphabet::symbol(std::int64_t number) const {
  int symbol = 0;
  while (c_[static_cast<std::size_t>(symbol) + 1] <= number) ++symbol;
  return symbol;
}

void Alphabet::learn(int symbol) {
  const int symbols = static_cast<int>(c_.size()) - 1;
  const std::vector<int> last =
      symbols == 8 ? std::vector{0, 1, 4, 12, 32, 100} : std::vector{0, -1, -1, 4, 10, 24, 56, 120};
  int r = 1;
  for (std::size_t rate = 1; rate < last.size(); ++rate) r += n_ > last[rate];
  for (int i = 1; i < symbols; ++i) {
    const std::int64_t t = i <= symbol ? 4 * i : 32768 - 4 * (symbols - i);
    std::int64_t& c = c_[static_cast<std::size_t>(i)];
    c += (t - c) >> r;
  }
  n_ = std::min(n_ + 1, 127);
}

SymbolReader::SymbolReader(ByteView bytes) : bytes_(bytes) {
  for (std::uint64_t& state : states_) state = take(7);
}

std::uint64_t SymbolReader::take(int bytes) {
  std::uint64_t value = 0;
  for (int i = 0; i < bytes; ++i, ++next_) {
    if (next_ < bytes_.size()) value |= std::uint64_t{bytes_[next_]} << (8 * i);
  }
  return value;
}

int SymbolReader::symbol(int state, Alphabet& alphabet) {
  std::uint64_t& x = states_[static_cast<std::size_t>(state)];
  const auto number = static_cast<std::int64_t>(x % 32768);
  const int symbol = alphabet.symbol(number);
  const std::int64_t begin = alphabet.frequencies()[static_cast<std::size_t>(symbol)];
  const std::int64_t end = alphabet.frequencies()[static_cast<std::size_t>(symbol) + 1];
  x = static_cast<std::uint64_t>(end - begin) * (x / 32768) +
      static_cast<std::uint64_t>(number - begin);
  if (x < 1 << 24) x = (x << 32) + take(4);
  alphabet.learn(symbol);
  return symbol;
}

std::int64_t SymbolReader::bits(int count) {
  std::int64_t value = 0;
  for (int i = 0; i < count; ++i, ++bits_read_) {
    const std::size_t byte = bits_read_ / 8;
    if (byte >= bytes_.size()) continue;
    const int bit = bytes_[bytes_.size() - 1 - byte] >> (bits_read_ % 8) & 1;
    value |= std::int64_t{bit} << i;
  }
  return value;
}

bool SymbolReader::complete_but_for_zeros() const {
  if (states_[0] != 1 << 24 || states_[1] != 1 << 24 || next_ > bytes_.size()) return false;
  return std::all_of(bytes_.begin() + static_cast<std::ptrdiff_t>(next_), bytes_.end(),
                     [](std::uint8_t byte) { return byte == 0; });
}

bool SymbolReader::complete() const {
  const std::size_t at_end = (bits_read_ + 7) / 8;
  if (states_[0] != 1 << 24 || states_[1] != 1 << 24 || next_ + at_end != bytes_.size()) {
    return false;
  }
  return bits_read_ % 8 == 0 || bytes_[bytes_.size() - at_end] >> (bits_read_ % 8) == 0;
}

}  // namespace pointreel::reference
