#include "codec/octree/neighbor_prediction.h"

#include <bit>

namespace pointreel {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

/// One place around a node: the octants there that touch the node, and where they lie in the
/// 4 x 4 x 4 cells around its own.
struct Place {
  int offset = 0;  ///< from a cell to its neighbour at this place
  std::array<std::uint8_t, 8> octant{}, cell{};
};

constexpr std::array<Place, 19> make_places() {
  std::array<Place, 19> places{};
  std::size_t count = 0;
  for (int away = 0; away <= 2; ++away) {  // itself, faces, edges
    for (int at = 0; at < 27; ++at) {
      const int step[3] = {at % 3 - 1, at / 3 % 3 - 1, at / 9 - 1};
      if ((step[0] != 0) + (step[1] != 0) + (step[2] != 0) != away) continue;
      Place& place = places[count++];
      place.offset = step[0] + 4 * step[1] + 16 * step[2];
      std::size_t touching = 0;
      for (int octant = 0; octant < 8; ++octant) {
        int cell = 0;
        bool touches = true;
        for (int axis = 2; axis >= 0; --axis) {
          const int x = 1 + 2 * step[axis] + (octant >> axis & 1);
          touches = touches && x >= 0 && x < 4;
          cell = 4 * cell + x;
        }
        if (!touches) continue;
        place.octant[touching] = static_cast<std::uint8_t>(octant);
        place.cell[touching++] = static_cast<std::uint8_t>(cell);
      }
    }
  }
  return places;
}

constexpr std::array<Place, 19> kPlaces = make_places();

}  // namespace

Neighborhoods::Neighborhoods(const Svo& svo) : svo_(&svo), nodes_(svo.node_count(0)) {
  for (Around& around : nodes_) {
    around.fill(kNone);
    around[0] = 0;
  }
}

/// Calls visit(cell, node, there) for each of the 56 cells that touch the node's octants, edges
/// included; `there` is all ones or, where no node is, zero. Without branches, which could not be
/// foreseen.
template <class Visit>
void Neighborhoods::visit_cells(const Around& around, Visit visit) const {
  const std::uint8_t* masks = svo_->masks.data();
  const std::uint32_t* first_child = svo_->first_child.data();
  const auto visit_place = [&](std::size_t number, std::size_t touching) {
    const std::uint32_t node = around[number];
    const bool there = node != kNone;
    const std::size_t index = there ? node : 0;
    const unsigned mask = there ? masks[index] : 0u;
    const std::uint32_t first = first_child[index];
    const Place& place = kPlaces[number];
    for (std::size_t i = 0; i < touching; ++i) {
      const unsigned bit = 1u << place.octant[i];
      const auto before = static_cast<std::uint32_t>(std::popcount(mask & (bit - 1)));
      visit(place.cell[i], first + before, (mask & bit) != 0 ? ~std::uint32_t{0} : 0u);
    }
  };
  visit_place(0, 8);
  for (std::size_t face = 1; face < 7; ++face) visit_place(face, 4);
  for (std::size_t edge = 7; edge < 19; ++edge) visit_place(edge, 2);
}

void Neighborhoods::descend() {
  std::vector<Around> below(svo_->node_count(level_ + 1));
  Around* child = below.data();
  const std::size_t begin = svo_->level_begin[static_cast<std::size_t>(level_)];
  std::array<std::uint32_t, 64> cells;
  cells.fill(kNone);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    visit_cells(nodes_[i], [&](std::size_t cell, std::uint32_t node, std::uint32_t there) {
      cells[cell] = node | ~there;
    });
    for (unsigned mask = svo_->masks[begin + i]; mask != 0; mask &= mask - 1, ++child) {
      const int middle = ValueBlock::cell(std::countr_zero(mask));
      for (std::size_t place = 0; place < kPlaces.size(); ++place) {
        (*child)[place] = cells[static_cast<std::size_t>(middle + kPlaces[place].offset)];
      }
    }
  }
  nodes_.swap(below);
  ++level_;
}

void Neighborhoods::load(std::uint32_t node, const std::vector<Short4>& values,
                         ValueBlock& block) const {
  const Around& around = nodes_[node - svo_->level_begin[static_cast<std::size_t>(level_)]];
  const Short4* value = values.data();
  visit_cells(around, [&](std::size_t cell, std::uint32_t at, std::uint32_t there) {
    std::uint64_t lanes;
    std::memcpy(&lanes, value + (at & there), sizeof(lanes));
    lanes &=
        static_cast<std::uint64_t>(static_cast<std::int64_t>(static_cast<std::int32_t>(there)));
    std::memcpy(block.values.data() + cell, &lanes, sizeof(lanes));
  });
}

}  // namespace pointreel
