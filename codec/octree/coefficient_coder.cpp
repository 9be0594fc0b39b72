#include "codec/octree/coefficient_coder.h"

#include <type_traits>

namespace pointreel {
namespace {

template <class Table>
void fill(Table& table, const Alphabet8& alphabet) {
  if constexpr (std::is_array_v<Table>) {
    for (auto& part : table) fill(part, alphabet);
  } else {
    table = alphabet;
  }
}

}  // namespace

/// Most alphabets begin with nothing known. Magnitudes halve in frequency.
CoefficientContexts::CoefficientContexts() {
  fill(first[1], Alphabet8(4));
  fill(first[3], Alphabet8(2));
  constexpr std::array<std::uint32_t, 8> kHalves = {128, 64, 32, 16, 8, 4, 2, 2};
  fill(magnitude, Alphabet8(kHalves, 0));
  fill(digits, Alphabet8(kHalves, 0));
  for (auto& component : leading) {
    component[1] = Alphabet8(2);
    component[2] = Alphabet8(4);
  }
}

}  // namespace pointreel
