#include "codec/surface/leaf_pairs.h"

#include <array>
#include <bit>
#include <cstddef>
#include <utility>

namespace pointreel {
namespace {

constexpr std::size_t kMiddle = 13;

/// What touches a child: the children of a node beside its parent that do, and for each where it
/// is. There is one for each place of that node around the parent, and each octant of the child.
struct Touching {
  std::uint8_t octants = 0;
  std::array<std::uint8_t, 8> place{};
};
using TouchingTable = std::array<std::array<Touching, 8>, 27>;

constexpr TouchingTable make_touching() {
  TouchingTable table{};
  for (unsigned node = 0; node < 27; ++node) {
    const unsigned offset[3] = {node % 3, node / 3 % 3, node / 9};
    for (unsigned child = 0; child < 8; ++child) {
      for (unsigned octant = 0; octant < 8; ++octant) {
        // Along each axis, in units of children, the other is this far up, plus 1.
        unsigned place = 0, scale = 1;
        bool touches = true;
        for (unsigned axis = 0; axis < 3; ++axis, scale *= 3) {
          const unsigned up = 2 * offset[axis] + (octant >> axis & 1u) - (child >> axis & 1u);
          touches = touches && up >= 1 && up <= 3;  // up - 2 is from -1 to 1
          place += (up - 1) * scale;
        }
        if (!touches) continue;
        table[node][child].octants |= static_cast<std::uint8_t>(1u << octant);
        table[node][child].place[octant] = static_cast<std::uint8_t>(place);
      }
    }
  }
  return table;
}
constexpr TouchingTable kTouching = make_touching();

}  // namespace

std::vector<LeafPair> leaf_pairs(const Svo& svo) {
  // Nodes of a level are in Morton order, so that the second child of a pair never belongs to an
  // earlier parent than the first.
  std::vector<LeafPair> above, below;
  for (int level = 0; level < svo.depth; ++level) {
    below.clear();
    const std::uint32_t begin = svo.level_begin[static_cast<std::size_t>(level)];
    const std::uint32_t end = svo.level_begin[static_cast<std::size_t>(level) + 1];
    std::size_t pair = 0;
    for (std::uint32_t node = begin; node < end; ++node) {
      const unsigned mask = svo.masks[node];
      const std::size_t first_pair = pair;
      while (pair < above.size() && above[pair].first == node - begin) ++pair;
      std::uint32_t child = svo.first_child[node] - end;
      const auto add = [&](const Touching& touching, unsigned others, std::uint32_t first) {
        for (unsigned found = others & touching.octants; found != 0; found &= found - 1) {
          const auto octant = static_cast<std::size_t>(std::countr_zero(found));
          const int before = std::popcount(others & ((1u << octant) - 1u));
          below.push_back(
              {child, first + static_cast<std::uint32_t>(before), touching.place[octant]});
        }
      };
      for (unsigned octants = mask; octants != 0; octants &= octants - 1, ++child) {
        const auto octant = static_cast<std::size_t>(std::countr_zero(octants));
        add(kTouching[kMiddle][octant], octants & (octants - 1), child + 1);
        for (std::size_t p = first_pair; p < pair; ++p) {
          const std::uint32_t other = begin + above[p].second;
          add(kTouching[above[p].place][octant], svo.masks[other], svo.first_child[other] - end);
        }
      }
    }
    std::swap(above, below);
  }
  return above;
}

}  // namespace pointreel
